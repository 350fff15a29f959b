#pragma once
// One run of a command: its report, its progress, its interruption, and how it ends.
#include <chrono>
#include <filesystem>
#include <functional>
#include <string>

#include "apps/tetloom/interruption.hpp"
#include "apps/tetloom/progress_display.hpp"
#include "apps/tetloom/report.hpp"
#include "core/base/stage_clock.hpp"
#include "tetloom/communicator.hpp"
#include "tetloom/tasks.hpp"

namespace tetloom::app {

/// What a run is told of its command.
struct RunSetup {
  std::filesystem::path input;
  std::filesystem::path output;  ///< empty: none
  std::filesystem::path report;  ///< empty: none
  bool quiet = false;
  int threads = 1;
  int parts = 1;
  Communicator* ranks = nullptr;  ///< those that run together; null: this process alone. The first speaks and writes.
};

/// One run of a command.
class Run {
 public:
  explicit Run(RunSetup setup);

  RunReport& report() { return report_; }
  const CancelToken& cancel() const { return interruption_.token(); }
  /// Progress to the display, cancellation from Ctrl-C.
  Host host();
  /// Shows that a stage of the command itself begins; throws Error(Cancelled) after Ctrl-C.
  void begin(Stage stage);
  /// The same on all ranks, or cancelled on all of them. A collective call.
  void begin_together(Stage stage);
  /// The ranks that carry out the body, for as long: what fails on one of them, anywhere, ends the body on all.
  Communicator& ranks() const { return *ranks_; }
  /// What standard output gets when the run is over, unless it is quiet.
  void set_text(std::string text) { text_ = std::move(text); }

  /// Carries out `body`, turns what it throws into errors of the report, prints and writes everything.
  ExitStatus execute(const std::function<void(Run&)>& body);

 private:
  void probe_outputs() const;
  void carry_out(const std::function<void(Run&)>& body);
  void note_seconds(RunSeconds& seconds) const;
  void print_diagnostics() const;
  void write_report_file();
  RunReport fresh_report() const;
  bool speaks() const { return setup_.ranks == nullptr || setup_.ranks->rank() == 0; }
  void leave();

  const RunSetup setup_;
  RunReport report_;
  Communicator* ranks_ = nullptr;  // while the body is carried out
  std::string text_;
  StageClock clock_;
  ProgressDisplay display_;
  Interruption interruption_;
};

/// Calls `read`; an error that blames an argument blames the input then: its extension, say.
template <class Read>
auto read_input(const Read& read) {
  try {
    return read();
  } catch (const Error& error) {
    if (error.code() != ErrorCode::InvalidArgument) throw;
    Diagnostic diagnostic = error.diagnostic();
    diagnostic.code = ErrorCode::InputUnreadable;
    throw Error(std::move(diagnostic));
  }
}

/// Seconds that `body` takes.
template <class Body>
double timed(const Body& body) {
  const auto start = std::chrono::steady_clock::now();
  body();
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

}  // namespace tetloom::app
