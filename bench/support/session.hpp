#pragma once
// What the benches of whole meshes have in common: their options, the heading, models, runs in alternation, the JSON.
#include <cstdio>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <vector>

#include "bench/support/command_line.hpp"
#include "bench/support/commit.hpp"
#include "bench/support/machine.hpp"
#include "bench/support/svg_plot.hpp"
#include "bench/support/temporary_folder.hpp"

namespace tetloom::bench {

struct SessionOptions {
  int runs = 3;
  bool quick = false, no_peer = false;
  std::string json_path = {}, svg_path = {}, commit = kCommit;
  std::string measure = {};  ///< a task, when this process is one of the measured ones
};

/// --runs, --json, --commit, --no-peer, --quick and --measure.
void add_session_options(CommandLine& line, SessionOptions& options);

/// --svg, for benches that draw.
void add_plot_option(CommandLine& line, SessionOptions& options);

/// 1, 2, 4 ... and all cores.
std::vector<int> all_threads(int cores);
/// Those asked for, or all of these where there are none; ascending, with 1, which others are compared with.
std::vector<int> compared_threads(std::vector<int> asked, int cores);

class Session {
 public:
  /// `name` is the bench's.
  Session(std::string name, const SessionOptions& options);

  const std::string& program() const { return program_; }  ///< this executable
  const Machine& machine() const { return machine_; }
  const std::filesystem::path& folder() const { return folder_.path(); }
  int runs() const { return options_.runs; }

  /// The commit, the machine, the runs, `peers`, and a warning where the machine is busy.
  void print_heading(const std::string& peers) const;

  /// What a plot of this bench is drawn with: `title`, the machine, the date, the commit, and `note`.
  Figure make_figure(const std::string& title, const std::string& note) const;

  /// `name` itself where it is a file, else the demo model of that name, made in the folder. Throws std::runtime_error.
  std::filesystem::path model_path(const std::string& name) const;

  /// All cases take turns, so that a machine that slows down slows all of them down: measure(case, run) for each, run
  /// after run. title(case) is for the log.
  template <class Case, class Title, class Measure>
  void take_turns(std::span<Case> cases, const Title& title, const Measure& measure) const {
    for (int run = 0; run < options_.runs; ++run) {
      for (Case& one : cases) {
        std::fprintf(stderr, "%s, run %d of %d\n", title(one).c_str(), run + 1, options_.runs);
        measure(one, run);
      }
    }
  }

  /// Writes the cases, with the machine and what ran, to the file of --json; nothing without that. `gmsh`: its version,
  /// empty where it did not run. Throws std::runtime_error.
  void write_json(const nlohmann::json& cases, const std::string& gmsh) const;

 private:
  std::string name_;
  SessionOptions options_;
  std::string program_;
  Machine machine_;
  double load_before_;
  TemporaryFolder folder_;
};

/// A main function: what `run` throws is printed, and the exit status 1.
int run_bench(const char* name, int (*run)(int, char**), int argc, char** argv);

}  // namespace tetloom::bench
