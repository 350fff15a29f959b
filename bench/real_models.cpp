// The claim: every real CAD model and every closed triangle surface is meshed, quickly and without flat elements.
// `tetloom mesh` and Gmsh with HXT run as a user would run them on all model files of the folders given, with the same
// sizes and threads; both meshes are judged by the same code. One line per model, then what they say together.
#include <algorithm>
#include <atomic>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <mutex>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

#include <nlohmann/json.hpp>

#include "bench/support/child_process.hpp"
#include "bench/support/model_files.hpp"
#include "bench/support/peer.hpp"
#include "bench/support/real_run.hpp"
#include "bench/support/real_table.hpp"
#include "bench/support/session.hpp"

namespace tetloom::bench {
namespace {

namespace fs = std::filesystem;

struct Options {
  std::vector<std::string> folders;
  std::string only;  ///< part of the names of the models to run, a regular expression; empty: all
  int jobs = 1;
  RealRunOptions run;
  SessionOptions session;
};

class Bench {
 public:
  explicit Bench(const Options& options) : options_(options), session_("real_models", options.session) {
    options_.run.judge = session_.program();
    if (!options.session.no_peer) gmsh_ = gmsh_version();
    options_.run.no_peer = gmsh_.empty();
  }

  void run() {
    const std::vector<fs::path> paths =
        options_.session.quick ? make_quick_models() : find_models(options_.folders, options_.only);
    if (paths.empty()) throw std::runtime_error("no model files");
    session_.print_heading("beside gmsh/HXT " + (gmsh_.empty() ? "not run" : gmsh_));
    print_table_heading();
    models_.resize(paths.size());
    std::vector<std::jthread> workers;
    for (int job = 0; job < options_.jobs; ++job) workers.emplace_back([&] { run_some(paths); });
    workers.clear();
    print_summary(models_);
    print_findings(models_);
    if (options_.session.quick) check_quick_models();
  }

 private:
  /// Takes models until none is left.
  void run_some(const std::vector<fs::path>& paths) {
    for (std::size_t i = next_++; i < paths.size(); i = next_++) {
      RealModel model = run_real_model(paths[i], options_.run);
      const std::lock_guard lock(mutex_);
      print_table_line(model);
      models_[i] = std::move(model);
      done_.push_back(i);
      write_json();
    }
  }

  /// Of the models done so far, so that a run that is broken off leaves what it has.
  void write_json() const {
    std::vector<std::size_t> order = done_;
    std::sort(order.begin(), order.end());
    nlohmann::json cases = nlohmann::json::array();
    for (const std::size_t i : order) cases.push_back(to_json(models_[i]));
    session_.write_json(cases, gmsh_);
  }

  /// A CAD model, a closed triangle surface, and a file that is none.
  std::vector<fs::path> make_quick_models() const {
    const fs::path tetrahedron = session_.folder() / "tetrahedron.obj", broken = session_.folder() / "broken.step";
    std::ofstream(tetrahedron) << "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\n";
    std::ofstream(broken) << "no model\n";
    return {broken, session_.model_path("sphere"), tetrahedron};
  }

  void check_quick_models() const {
    if (is_valid(models_[0])) throw std::runtime_error("a broken file counts as valid");
    for (std::size_t i = 1; i < models_.size(); ++i)
      if (!is_valid(models_[i])) throw std::runtime_error(models_[i].name + " does not count as valid");
    const double sphere = models_[1].tetloom.mesh->surface_distance.value_or(0);
    if (sphere <= 0 || sphere > .1) throw std::runtime_error("no such distance from a sphere");
  }

  Options options_;
  Session session_;
  std::string gmsh_;
  std::vector<RealModel> models_;
  std::atomic<std::size_t> next_ = 0;  ///< the model to take; its partners are the other workers
  std::mutex mutex_;                   ///< of what is printed and noted
  std::vector<std::size_t> done_;
};

void add_run_options(CommandLine& line, RealRunOptions& run) {
  line.add("--relative-size", run.relative_size, "target size as a share of the box's diagonal").positive();
  line.add("--curvature", run.curvature, "edges per full turn");
  line.add("--threads", run.threads, "of each mesher").positive();
  line.add("--timeout", run.timeout, "seconds that each mesher may take").positive();
  line.add_flag("--distance", run.distance, "measure how far tetloom's surfaces lie from the models");
  line.add("--command", run.command, "the tetloom to run");
  line.add("--options", run.options, "more options for tetloom mesh, with blanks between them");
}

/// Those of other benches, but that a model is run once.
void add_output_options(CommandLine& line, SessionOptions& session) {
  line.add("--json", session.json_path, "write everything measured to this file as well");
  line.add("--commit", session.commit, "the commit to name");
  line.add_flag("--no-peer", session.no_peer, "run no peer beside");
  line.add_flag("--quick", session.quick, "models made on the spot, only to see that it works");
  line.add("--measure", session.measure, "").hidden();
}

int judge(const std::string& task_text) {
  const nlohmann::json figures = judge_mesh_file(nlohmann::json::parse(task_text).get<JudgeTask>());
  std::puts(figures.dump().c_str());
  return 0;
}

int run(int argc, char** argv) {
  Options options;
  options.session.runs = 1;
  options.run.command = TETLOOM_COMMAND;
  CommandLine line("tetloom beside Gmsh with HXT on real models: what is meshed, how fast and how well", "real_models");
  line.add("FOLDERS", options.folders, "folders with models, or model files");
  line.add("--only", options.only, "only models whose names match this regular expression, in any case");
  line.add("--jobs", options.jobs, "models that run at once; 1 where times are to be quoted").positive();
  add_run_options(line, options.run);
  add_output_options(line, options.session);
  if (const auto status = line.parse(argc, argv)) return *status;
  if (!options.session.measure.empty()) return judge(options.session.measure);
  if (options.session.quick) options.run.relative_size = 0.1, options.run.distance = true;
  Bench(options).run();
  return 0;
}

}  // namespace
}  // namespace tetloom::bench

int main(int argc, char** argv) { return tetloom::bench::run_bench("real_models", tetloom::bench::run, argc, argv); }
