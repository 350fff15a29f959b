// The claim: tetloom meshes surfaces at least twice as fast as gmsh's 2D stage with 2 threads, and from 1 to 2 threads
// at least 1.8 times as fast on models of 20 or more faces. Both meshers run on the same file, size and number of
// threads, in alternation, each run in a process of its own; the median counts.
#include <CLI/CLI.hpp>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <string>
#include <vector>

#include "bench/support/child_process.hpp"
#include "bench/support/commit.hpp"
#include "bench/support/machine.hpp"
#include "bench/support/peer.hpp"
#include "bench/support/surface_run.hpp"
#include "bench/support/surface_table.hpp"
#include "bench/support/temporary_folder.hpp"
#include "core/cad/read_model.hpp"
#include "core/sizing/size_field.hpp"

namespace tetloom::bench {
namespace {

namespace fs = std::filesystem;

struct Options {
  std::vector<std::string> models = {"spline-block", "filleted-plate"};
  std::vector<double> triangles = {50e3, 200e3, 600e3};
  std::vector<int> threads;  ///< empty: 1, 2, 4 … and all cores
  int runs = 5;
  bool quick = false, no_peer = false;
  std::string json_path, commit = kCommit;
  std::string measure;  ///< a task, when this process is one of the measured ones
};

/// A model file, or the name of a demo model, with what the sizes follow from.
struct BenchModel {
  std::string name;
  fs::path path;
  std::size_t faces = 0;
  double area = 0;
};

BenchModel prepare_model(const std::string& name, const fs::path& folder) {
  BenchModel model{fs::path(name).stem().string(), name, 0, 0};
  if (!fs::exists(name)) {
    model.path = folder / (name + ".step");
    const ChildResult made = run_child({TETLOOM_DEMO_MODEL, name, model.path});
    if (made.exit_status != 0) throw std::runtime_error("cannot make the model '" + name + "': " + made.output);
  }
  const ModelDocument document = read_model(model.path);
  model.faces = document.model->topology().face_count();
  for (std::size_t f = 0; f < model.faces; ++f) model.area += document.model->area(ModelFaceId(f));
  return model;
}

/// The size, of three digits, that gives about this many triangles.
double size_for(double triangles, double area) {
  const double size = std::sqrt(kTrianglesPerSquare * area / triangles);
  const double digit = std::pow(10, std::floor(std::log10(size)) - 2);
  return digit * std::round(size / digit);
}

std::vector<int> all_threads(int cores) {
  std::vector<int> threads;
  for (int t = 1; t <= cores; t *= 2) threads.push_back(t);
  if (threads.back() != cores) threads.push_back(cores);
  return threads;
}

class Bench {
 public:
  explicit Bench(const Options& options)
      : options_(options), program_(fs::read_symlink("/proc/self/exe")), machine_(describe_machine()) {
    if (!options_.no_peer) gmsh_ = gmsh_version();
    if (options_.threads.empty()) options_.threads = all_threads(machine_.cores);
    load_before_ = load_average();
  }

  void run() {
    print_heading();
    for (const std::string& name : options_.models) {
      const BenchModel model = prepare_model(name, folder_.path());
      for (const double triangles : options_.triangles) measure_size(model, size_for(triangles, model.area));
    }
    print_table(cases_);
    std::printf("\n");
    print_claims(cases_);
    check_meshes();
    if (!options_.json_path.empty()) write_json();
  }

 private:
  void print_heading() const {
    std::printf("surface_speed, commit %s, built by %s\n%s, %d cores, %.1f GiB, %s\n", options_.commit.c_str(),
                TETLOOM_BUILD, machine_.processor.c_str(), machine_.cores,
                static_cast<double>(machine_.memory) / (1 << 30), machine_.system.c_str());
    std::printf("%d runs each in alternation, the median counts; %s\n", options_.runs, peer_text().c_str());
    if (load_before_ > 0.5) {
      std::printf("The machine is BUSY: a load of %.2f before this run. Its figures are not fit to be quoted.\n",
                  load_before_);
    }
    std::printf("\n");
    std::fflush(stdout);
  }

  std::string peer_text() const {
    if (options_.no_peer) return "without gmsh, as asked";
    return gmsh_.empty() ? "gmsh is not installed, so it does not run beside" : "beside gmsh " + gmsh_;
  }

  /// All numbers of threads take turns, so that a machine that slows down slows all of them down.
  void measure_size(const BenchModel& model, double size) {
    const std::size_t first = cases_.size();
    for (const int threads : options_.threads) {
      cases_.push_back({model.name, model.faces, {model.path, size, threads}, {}, {}});
    }
    for (int run = 0; run < options_.runs; ++run) {
      for (std::size_t c = first; c < cases_.size(); ++c) {
        SurfaceCase& one = cases_[c];
        std::fprintf(stderr, "%s, h %g, %d threads, run %d of %d\n", one.model_name.c_str(), size, one.task.threads,
                     run + 1, options_.runs);
        one.tetloom.samples.push_back(measure_apart(program_, one.task));
        if (!gmsh_.empty()) one.gmsh.samples.push_back(measure_gmsh(one.task, folder_.path()));
      }
    }
  }

  /// Speed that is paid for with wrong meshes is none. The cases of one model and size follow each other.
  void check_meshes() const {
    double seconds = 0, triangles = 0;
    const SurfaceCase* first = nullptr;
    for (const SurfaceCase& one : cases_) {
      if (first == nullptr || first->model_name != one.model_name || first->task.size != one.task.size) first = &one;
      for (const SurfaceSample& sample : one.tetloom.samples) {
        const std::string where = one.model_name + " with " + std::to_string(one.task.threads) + " threads: ";
        if (sample.digest != first->tetloom.samples.front().digest) {
          throw std::runtime_error(where + "not the mesh that the first run gave");
        }
        if (sample.intersections > 0) throw std::runtime_error(where + "the surface crosses itself");
        if (one.task.threads != 1) continue;
        seconds += sample.intersection_seconds;
        triangles += static_cast<double>(sample.triangles);
      }
    }
    std::printf("\nEvery mesh is free of self-intersections and the same for all numbers of threads.\n");
    if (seconds > 0) std::printf("Self-intersection test, 1 thread: %.0f k triangles/s\n", 1e-3 * triangles / seconds);
  }

  void write_json() const {
    nlohmann::json cases = nlohmann::json::array();
    for (const SurfaceCase& one : cases_) cases.push_back(to_json(one));
    const nlohmann::json report = {{"bench", "surface_speed"},
                                   {"schema", 1},
                                   {"commit", options_.commit},
                                   {"build", TETLOOM_BUILD},
                                   {"machine",
                                    {{"processor", machine_.processor},
                                     {"cores", machine_.cores},
                                     {"memory", machine_.memory},
                                     {"system", machine_.system}}},
                                   {"load_average", {{"before", load_before_}, {"after", load_average()}}},
                                   {"gmsh", gmsh_.empty() ? nlohmann::json() : nlohmann::json(gmsh_)},
                                   {"cases", cases}};
    std::ofstream file(options_.json_path);
    file << report.dump(2) << '\n';
    if (!file.flush()) throw std::runtime_error("cannot write '" + options_.json_path + "'");
  }

  Options options_;
  std::string program_, gmsh_;
  Machine machine_;
  double load_before_ = 0;
  TemporaryFolder folder_;
  std::vector<SurfaceCase> cases_;
};

void add_options(CLI::App& app, Options& options) {
  app.add_option("--models", options.models, "demo models or CAD files")->delimiter(',')->capture_default_str();
  app.add_option("--triangles", options.triangles, "about how many triangles")
      ->delimiter(',')
      ->check(CLI::PositiveNumber)
      ->capture_default_str();
  app.add_option("--threads", options.threads, "numbers of threads; default: 1, 2, 4 ... and all cores")
      ->delimiter(',')
      ->check(CLI::PositiveNumber);
  app.add_option("--runs", options.runs, "runs of each")->check(CLI::PositiveNumber)->capture_default_str();
  app.add_option("--json", options.json_path, "write everything measured to this file as well");
  app.add_option("--commit", options.commit, "the commit to name")->capture_default_str();
  app.add_flag("--no-peer", options.no_peer, "do not run gmsh beside");
  app.add_flag("--quick", options.quick, "one run of small meshes with 1 and 2 threads, only to see that it works");
  app.add_option("--measure", options.measure, "")->group("");
}

int run(int argc, char** argv) {
  Options options;
  CLI::App app("Speed of tetloom's surface meshing, beside gmsh where it is installed", "surface_speed");
  add_options(app, options);
  CLI11_PARSE(app, argc, argv);
  if (!options.measure.empty()) {
    const nlohmann::json task = nlohmann::json::parse(options.measure);
    const SurfaceSample sample = measure_here(
        {task.at("model").get<std::string>(), task.at("size").get<double>(), task.at("threads").get<int>()});
    std::puts(nlohmann::json(sample).dump().c_str());
    return 0;
  }
  if (options.quick) {
    options.runs = 1;
    options.triangles = {2e3};
    options.threads = {1, 2};
  }
  Bench(options).run();
  return 0;
}

}  // namespace
}  // namespace tetloom::bench

int main(int argc, char** argv) {
  try {
    return tetloom::bench::run(argc, argv);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "surface_speed: %s\n", error.what());
    return 1;
  }
}
