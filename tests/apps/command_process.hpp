#pragma once
// Runs programs of tetloom as processes of their own and looks at what they leave behind.
#include <sys/types.h>

#include <chrono>
#include <filesystem>
#include <functional>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "tests/support/in_time.hpp"
#include "tests/support/temporary_folder.hpp"

namespace tetloom::test {

struct ProcessOptions {
  std::function<void()> in_child;          ///< after fork and before exec: limits, signal dispositions …
  std::optional<std::string> signal_when;  ///< once standard error contains this text, `signals` are sent
  std::vector<int> signals;
  bool close_stdout = false;   ///< the reader of standard output is gone from the start
  double limit_seconds = 120;  ///< the process is killed after that, and the test fails
};

struct ProcessResult {
  int status = -1;  ///< exit status, or 128 + the signal that ended it
  std::string out, err;
  double seconds_after_signal = 0;
};

/// argv[0] is the path of the program.
ProcessResult run_process(const std::vector<std::string>& argv, const ProcessOptions& options = {});

/// Runs the tetloom command of this build.
ProcessResult run_tetloom(std::vector<std::string> arguments, const ProcessOptions& options = {});

/// A temporary folder whose paths are arguments of commands.
class TestFolder {
 public:
  std::string operator/(const std::string& name) const { return (folder_ / name).string(); }
  /// Names of all files, sorted; temporaries too.
  std::vector<std::string> files() const;
  std::string write(const std::string& name, const std::string& text) const {
    return folder_.write(name, text).string();
  }

 private:
  TemporaryFolder folder_;
};

inline std::string read_text(const std::string& path) { return file_content(path); }
nlohmann::json read_json(const std::string& path);

/// The demo model of that kind ("part", "assembly", "plate", "spline"), made once per test run.
std::string demo_model(const std::string& kind);

/// A cube as an ASCII STL file; `facets` of its 12 triangles are written.
std::string cube_stl(int facets = 12);

/// Whether this build is instrumented: limits on memory do not work then, and everything takes longer.
bool is_sanitized();

/// What a run that was told to stop may take.
inline const double kMostSecondsToCancel = is_sanitized() ? 3.0 : 1.3;

/// A run that was told to stop has said so in `folder`/r.json and left nothing but `files`.
void check_cancelled(const ProcessResult& result, const TestFolder& folder, const std::vector<std::string>& files);

}  // namespace tetloom::test
