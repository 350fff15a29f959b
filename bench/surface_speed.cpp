// The claim: tetloom meshes surfaces at least twice as fast as gmsh's 2D stage with 2 threads, and from 1 to 2 threads
// at least 1.8 times as fast on models of 20 or more faces. Both meshers run on the same file, size and number of
// threads, in alternation, each run in a process of its own; the median counts.
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <span>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

#include "bench/support/peer.hpp"
#include "bench/support/session.hpp"
#include "bench/support/surface_run.hpp"
#include "bench/support/surface_table.hpp"
#include "tetloom/model.hpp"
#include "tetloom/size_field.hpp"

namespace tetloom::bench {
namespace {

namespace fs = std::filesystem;

struct Options {
  std::vector<std::string> models = {"spline-block", "filleted-plate"};
  std::vector<double> triangles = {50e3, 200e3, 600e3};
  std::vector<int> threads;  ///< empty: 1, 2, 4 … and all cores
  SessionOptions session{.runs = 5};
};

/// A model file, or the name of a demo model, with what the sizes follow from.
struct BenchModel {
  std::string name;
  fs::path path;
  std::size_t faces = 0;
  double area = 0;
};

BenchModel prepare_model(const fs::path& path) {
  BenchModel model{path.stem().string(), path, 0, 0};
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

class Bench {
 public:
  explicit Bench(const Options& options) : options_(options), session_("surface_speed", options.session) {
    if (!options.session.no_peer) gmsh_ = gmsh_version();
    if (options_.threads.empty()) options_.threads = all_threads(session_.machine().cores);
  }

  void run() {
    session_.print_heading(peer_text());
    for (const std::string& name : options_.models) {
      const BenchModel model = prepare_model(session_.model_path(name));
      for (const double triangles : options_.triangles) measure_size(model, size_for(triangles, model.area));
    }
    print_table(cases_);
    std::printf("\n");
    print_claims(cases_);
    check_meshes();
    write_json();
  }

 private:
  std::string peer_text() const {
    if (options_.session.no_peer) return "without gmsh, as asked";
    return gmsh_.empty() ? "gmsh is not installed, so it does not run beside" : "beside gmsh " + gmsh_;
  }

  void measure_size(const BenchModel& model, double size) {
    const std::size_t first = cases_.size();
    for (const int threads : options_.threads) {
      cases_.push_back({model.name, model.faces, {model.path, size, threads}, {}, {}});
    }
    session_.take_turns(std::span(cases_).subspan(first), title_of, [this](SurfaceCase& one, int) {
      one.tetloom.samples.push_back(measure_apart(session_.program(), one.task));
      if (!gmsh_.empty()) one.gmsh.samples.push_back(measure_gmsh(one.task, session_.folder()));
    });
  }

  static std::string title_of(const SurfaceCase& one) {
    std::ostringstream text;
    text << one.model_name << ", h " << one.task.size << ", " << one.task.threads << " threads";
    return text.str();
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
    session_.write_json(cases, gmsh_);
  }

  Options options_;
  Session session_;
  std::string gmsh_;
  std::vector<SurfaceCase> cases_;
};

void add_options(CommandLine& line, Options& options) {
  line.add("--models", options.models, "demo models or CAD files");
  line.add("--triangles", options.triangles, "about how many triangles").positive();
  line.add("--threads", options.threads, "numbers of threads; default: 1, 2, 4 ... and all cores").positive();
  add_session_options(line, options.session);
}

int run(int argc, char** argv) {
  Options options;
  CommandLine line("Speed of tetloom's surface meshing, beside gmsh where it is installed", "surface_speed");
  add_options(line, options);
  if (const auto status = line.parse(argc, argv)) return *status;
  if (!options.session.measure.empty()) {
    const nlohmann::json task = nlohmann::json::parse(options.session.measure);
    const SurfaceSample sample = measure_here(
        {task.at("model").get<std::string>(), task.at("size").get<double>(), task.at("threads").get<int>()});
    std::puts(nlohmann::json(sample).dump().c_str());
    return 0;
  }
  if (options.session.quick) {
    options.session.runs = 1;
    options.triangles = {2e3};
    options.threads = {1, 2};
  }
  Bench(options).run();
  return 0;
}

}  // namespace
}  // namespace tetloom::bench

int main(int argc, char** argv) { return tetloom::bench::run_bench("surface_speed", tetloom::bench::run, argc, argv); }
