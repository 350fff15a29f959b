#include "bench/support/session.hpp"

#include <algorithm>
#include <exception>
#include <fstream>
#include <stdexcept>
#include <utility>

#include "bench/support/child_process.hpp"

namespace tetloom::bench {

namespace fs = std::filesystem;

void add_session_options(CommandLine& line, SessionOptions& options) {
  line.add("--runs", options.runs, "runs of each").positive();
  line.add("--json", options.json_path, "write everything measured to this file as well");
  line.add("--commit", options.commit, "the commit to name");
  line.add_flag("--no-peer", options.no_peer, "run no peer beside");
  line.add_flag("--quick", options.quick, "one run of small meshes with 1 and 2 threads, only to see that it works");
  line.add("--measure", options.measure, "").hidden();
}

void add_plot_option(CommandLine& line, SessionOptions& options) {
  line.add("--svg", options.svg_path, "draw what was measured into this file");
}

std::vector<int> all_threads(int cores) {
  std::vector<int> threads;
  for (int t = 1; t <= cores; t *= 2) threads.push_back(t);
  if (threads.back() != cores) threads.push_back(cores);
  return threads;
}

std::vector<int> compared_threads(std::vector<int> asked, int cores) {
  std::vector<int> threads = asked.empty() ? all_threads(cores) : std::move(asked);
  threads.push_back(1);
  std::sort(threads.begin(), threads.end());
  threads.erase(std::unique(threads.begin(), threads.end()), threads.end());
  return threads;
}

Session::Session(std::string name, const SessionOptions& options)
    : name_(std::move(name)),
      options_(options),
      program_(fs::read_symlink("/proc/self/exe")),
      machine_(describe_machine()),
      load_before_(load_average()) {}

void Session::print_heading(const std::string& peers) const {
  std::printf("%s, commit %s, built by %s\n%s, %d cores, %.1f GiB, %s\n", name_.c_str(), options_.commit.c_str(),
              TETLOOM_BUILD, machine_.processor.c_str(), machine_.cores,
              static_cast<double>(machine_.memory) / (1 << 30), machine_.system.c_str());
  if (options_.runs == 1) std::printf("one run each; %s\n", peers.c_str());
  if (options_.runs > 1)
    std::printf("%d runs each in alternation, the median counts; %s\n", options_.runs, peers.c_str());
  if (load_before_ > 0.5) {
    std::printf("The machine is BUSY: a load of %.2f before this run. Its figures are not fit to be quoted.\n",
                load_before_);
  }
  std::printf("\n");
  std::fflush(stdout);
}

Figure Session::make_figure(const std::string& title, const std::string& note) const {
  char machine[256], run[256];
  std::snprintf(machine, sizeof(machine), "%s, %d cores, %.1f GiB, %s%s", machine_.processor.c_str(), machine_.cores,
                static_cast<double>(machine_.memory) / (1 << 30), machine_.system.c_str(),
                load_before_ > 0.5 ? "; BUSY with other work" : "");
  std::snprintf(run, sizeof(run), "%s, commit %s, %s, median of %d", name_.c_str(), options_.commit.c_str(),
                today().c_str(), options_.runs);
  return {title, {machine, run, note}, {}};
}

fs::path Session::model_path(const std::string& name) const {
  if (fs::exists(name)) return name;
  const fs::path path = folder() / (name + ".step");
  const ChildResult made = run_child({TETLOOM_DEMO_MODEL, name, path});
  if (made.exit_status != 0) throw std::runtime_error("cannot make the model '" + name + "': " + made.output);
  return path;
}

void Session::write_json(const nlohmann::json& cases, const std::string& gmsh) const {
  if (options_.json_path.empty()) return;
  const nlohmann::json report = {{"bench", name_},
                                 {"schema", 1},
                                 {"commit", options_.commit},
                                 {"date", today()},
                                 {"build", TETLOOM_BUILD},
                                 {"machine",
                                  {{"processor", machine_.processor},
                                   {"cores", machine_.cores},
                                   {"memory", machine_.memory},
                                   {"system", machine_.system}}},
                                 {"load_average", {{"before", load_before_}, {"after", load_average()}}},
                                 {"gmsh", gmsh.empty() ? nlohmann::json() : nlohmann::json(gmsh)},
                                 {"cases", cases}};
  std::ofstream file(options_.json_path);
  file << report.dump(2) << '\n';
  if (!file.flush()) throw std::runtime_error("cannot write '" + options_.json_path + "'");
}

int run_bench(const char* name, int (*run)(int, char**), int argc, char** argv) {
  try {
    return run(argc, argv);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s: %s\n", name, error.what());
    return 1;
  }
}

}  // namespace tetloom::bench
