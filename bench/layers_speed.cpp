// The claim: layers are grown at 3 million cells a second on one thread and written at 20 million, take less than a
// third of a run, at most 60 bytes per cell beside the mesh, and are the same for any number of threads. Beside
// snappyHexMesh of OpenFOAM, where it is installed.
#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "bench/support/child_process.hpp"
#include "bench/support/layer_run.hpp"
#include "bench/support/layer_stage.hpp"
#include "bench/support/session.hpp"
#include "bench/support/snappy.hpp"
#include "tetloom/io.hpp"

namespace tetloom::bench {
namespace {

namespace fs = std::filesystem;

struct Options {
  std::vector<std::string> models{"machined-part", "manifold"};
  double relative_size = 0.01;
  std::vector<int> threads;
  std::string setting = "A";
  SessionOptions session;
};

struct Case {
  std::string name;
  fs::path model;
  double edge = 0;
  int threads = 1;
  std::vector<LayerStageSample> stages;
  std::vector<LayerRun> runs;
};

template <class Sample, class Value>
double median_of(const std::vector<Sample>& samples, const Value& value) {
  std::vector<double> values;
  for (const Sample& sample : samples) values.push_back(value(sample));
  std::ranges::sort(values);
  return values.empty() ? 0 : values[values.size() / 2];
}

class Bench {
 public:
  explicit Bench(const Options& options) : options_(options), session_("layers_speed", options.session) {
    setting_ = *std::ranges::find(layer_settings(), options.setting, &LayerSetting::name);
    snappy_ = !options.session.no_peer && has_snappy();
  }

  void run() {
    session_.print_heading(snappy_ ? "beside snappyHexMesh" : "snappyHexMesh not run");
    make_cases();
    session_.take_turns(
        std::span(cases_), [](const Case& one) { return one.name + ", " + std::to_string(one.threads) + " threads"; },
        [&](Case& one, int run) { measure(one, run); });
    print();
    if (snappy_) run_peer();
    session_.write_json(json_, "");
  }

 private:
  void make_cases() {
    for (const std::string& name : options_.models)
      for (const int threads : compared_threads(options_.threads, session_.machine().cores)) {
        Case one{name, session_.model_path(name), 0, threads, {}, {}};
        one.edge = edge_of(one.model, options_.relative_size);
        cases_.push_back(std::move(one));
      }
  }

  void measure(Case& one, int) {
    const LayerStageTask task{one.model, one.edge, setting_.first_height * one.edge, 1.2, setting_.count, one.threads};
    const ChildResult child = run_child({session_.program(), "--measure", nlohmann::json(task).dump()});
    const nlohmann::json said = nlohmann::json::parse(child.output, nullptr, false);
    if (child.exit_status != 0 || !said.is_object()) throw std::runtime_error(one.name + ": " + child.output);
    one.stages.push_back(said.get<LayerStageSample>());
    LayerTask whole;
    whole.model = one.model, whole.setting = setting_, whole.relative_size = options_.relative_size;
    whole.threads = one.threads, whole.by_check_mesh = false;
    one.runs.push_back(run_layers(whole, session_.program(), session_.folder() / "run"));
    if (!one.runs.back().made_mesh() || !one.runs.back().verdict.is_valid())
      throw std::runtime_error(one.name + ": " + one.runs.back().failure + one.runs.back().verdict.problem);
  }

  void print() {
    std::printf("%-16s %8s %12s %12s %12s %9s %8s %10s %9s\n", "model", "threads", "layer cells", "grown M/s",
                "written M/s", "speed-up", "share%", "bytes/cell", "digest");
    for (const Case& one : cases_) print_case(one, first_of(one));
    std::printf(
        "\nGrown: from the surface mesh to proven layers. Share: of the whole run. Bytes: peak beside the layers "
        "in the mesh.\n");
  }

  // The same model on one thread.
  const Case& first_of(const Case& one) const { return *std::ranges::find(cases_, one.name, &Case::name); }

  void print_case(const Case& one, const Case& first) {
    const auto grow = [](const LayerStageSample& sample) { return sample.grow; };
    const double cells = static_cast<double>(one.stages.front().cells), seconds = median_of(one.stages, grow);
    const double write = median_of(one.stages, [](const LayerStageSample& sample) { return sample.write; });
    const double share = median_of(one.runs, [](const LayerRun& run) { return run.layer_seconds / run.seconds; });
    const double bytes = median_of(one.stages, [](const LayerStageSample& s) { return s.bytes_over_result(); });
    const double speed_up = median_of(first.stages, grow) / seconds;
    for (const auto& sample : one.stages)
      if (sample.digest != first.stages.front().digest) throw std::runtime_error(one.name + ": layers differ");
    for (const LayerRun& run : one.runs)
      if (run.digest != first.runs.front().digest) throw std::runtime_error(one.name + ": meshes differ");
    std::printf("%-16s %8d %12.0f %12.2f %12.1f %9.2f %8.1f %10.1f %9.8s\n", one.name.c_str(), one.threads, cells,
                cells / seconds / 1e6, cells / write / 1e6, speed_up, 100 * share, bytes,
                one.runs.front().digest.c_str());
    json_.push_back({{"model", one.name},
                     {"threads", one.threads},
                     {"stages", one.stages},
                     {"speed_up", speed_up},
                     {"share", share},
                     {"bytes_per_cell_over_result", bytes},
                     {"run", to_json(one.runs.front())}});
  }

  void run_peer() {
    std::printf("\n%-16s %12s %12s %8s %10s %9s\n", "snappyHexMesh", "layer cells", "cells/s", "layers", "thickness%",
                "seconds");
    for (const Case& one : cases_) {
      if (one.threads != 1) continue;
      const SnappySample sample = run_snappy(peer_task(one), session_.folder() / "snappy");
      if (!sample.failure.empty()) {
        std::printf("%-16s fails: %s\n", one.name.c_str(), sample.failure.c_str());
        continue;
      }
      std::printf("%-16s %12llu %12.0f %8.1f %10.1f %9.1f\n", one.name.c_str(),
                  static_cast<unsigned long long>(sample.layer_cells),
                  static_cast<double>(sample.cells) / sample.seconds, sample.layers, 100 * sample.thickness,
                  sample.seconds);
      json_.push_back({{"model", one.name},
                       {"peer", "snappyHexMesh"},
                       {"cells", sample.cells},
                       {"layer_cells", sample.layer_cells},
                       {"layers", sample.layers},
                       {"thickness", sample.thickness},
                       {"seconds", sample.seconds}});
    }
  }

  SnappyTask peer_task(const Case& one) {
    const fs::path surface = session_.folder() / "surface.stl", volume = session_.folder() / "volume.vtu";
    for (const fs::path& output : {surface, volume}) {
      const ChildResult made =
          run_child({TETLOOM_COMMAND, "mesh", one.model, "-o", output, "--size", std::to_string(one.edge), "--quiet"});
      if (made.exit_status != 0) throw std::runtime_error(made.output);
    }
    const Mesh mesh = read_mesh(volume);
    SnappyTask task;
    task.surface = surface;
    task.edge = one.edge, task.first_height = setting_.first_height * one.edge, task.count = setting_.count;
    const Box3 box = box_of(mesh.points);
    task.low = box.lo, task.high = box.hi;
    // The middle of the tet that has the most room around it.
    double most = 0;
    for (const auto& [a, b, c, d] : mesh.tet_to_vert) {
      const Vec3 &x = mesh.points[a], &y = mesh.points[b], &z = mesh.points[c], &w = mesh.points[d];
      const double volume_of = dot(cross(y - x, z - x), w - x);
      if (volume_of <= most) continue;
      most = volume_of;
      task.inside = 0.25 * (x + y + z + w);
    }
    return task;
  }

  Options options_;
  Session session_;
  LayerSetting setting_;
  bool snappy_ = false;
  std::vector<Case> cases_;
  nlohmann::json json_ = nlohmann::json::array();
};

int run(int argc, char** argv) {
  Options options;
  CommandLine line("Boundary layers: cells a second, share of the run, memory, threads", "layers_speed");
  line.add("--models", options.models, "demo models, or model files");
  line.add("--relative-size", options.relative_size, "mean edge, as a share of the model's diagonal").positive();
  line.add("--threads", options.threads, "numbers of threads; default: 1, 2, 4 ... and all cores");
  line.add("--setting", options.setting, "A, B or C").one_of({"A", "B", "C"});
  add_session_options(line, options.session);
  if (const auto status = line.parse(argc, argv)) return *status;
  if (const std::string& task = options.session.measure; !task.empty()) {
    const bool is_stage = task.front() == '{';
    const nlohmann::json said =
        is_stage ? nlohmann::json(measure_layer_stage(nlohmann::json::parse(task).get<LayerStageTask>()))
                 : judge_layers(task);
    std::puts(said.dump().c_str());
    return 0;
  }
  if (options.session.quick) {
    options.session.runs = 1;
    options.relative_size = 0.05;
    options.models = {"machined-part"};
    options.threads = {1, 2};
  }
  Bench(options).run();
  return 0;
}

}  // namespace
}  // namespace tetloom::bench

int main(int argc, char** argv) { return tetloom::bench::run_bench("layers_speed", tetloom::bench::run, argc, argv); }
