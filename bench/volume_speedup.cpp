// The claim: volumes are filled at least 1.5 times as fast on 2 threads and 2 times on 4 as on one, beside the best
// serial run (one part, one thread) as beside the same parts on one thread. What the tasks of a run would give on up to
// 64 threads is predicted from them, and says so.
#include <cstdio>
#include <filesystem>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include <nlohmann/json.hpp>

#include "bench/support/machine.hpp"
#include "bench/support/prediction.hpp"
#include "bench/support/session.hpp"
#include "bench/support/speedup_plot.hpp"
#include "bench/support/stage_run.hpp"
#include "bench/support/trace_file.hpp"
#include "bench/support/volume_run.hpp"
#include "bench/support/ways.hpp"

namespace tetloom::bench {
namespace {

namespace fs = std::filesystem;

struct Options {
  std::string model = "spline-block";
  std::vector<double> tets = {1e6, 5e6, 20e6};
  std::vector<int> threads;  ///< empty: 1, 2, 4 ... and all cores
  double tets_per_part = 0;
  std::vector<int> workers = {1, 2, 4, 8, 16, 32, 64};
  double latency_us = 1e6 * MessageCosts::kLatency, bandwidth_gb = 1e-9 * MessageCosts::kBandwidth;
  std::string prediction_path, trace_path, replay_path;
  SessionOptions session;

  MessageCosts costs() const { return {1e-6 * latency_us, 1e9 * bandwidth_gb}; }
};

using StageWay = Way<StageTask, StageSample>;

/// One size of mesh. `ways`: the serial run in one part, then parts on each number of threads, one first.
struct SpeedupCase {
  double wanted = 0;  ///< tets, about
  double size = 0;
  std::vector<StageWay> ways = {};
  RecordedStage volume = {};  ///< parts on one thread
  std::vector<Prediction> predictions = {};

  double tets() const { return static_cast<double>(ways[1].samples.front().tets); }
  std::string title() const {
    char text[32];
    std::snprintf(text, sizeof(text), "%.3g M tets", 1e-6 * tets());
    return text;
  }
};

enum class Basis { OnePart, OneThread };

StageSample basis_of(const SpeedupCase& one, Basis basis) {
  return basis == Basis::OnePart ? best_stages(one.ways[0].samples) : median_stages(one.ways[1].samples);
}

void print_line(const char* name, const StageSample& sample, const StageSample* basis) {
  std::printf("  %-20s", name);
  for (const StageKind& stage : kStages)
    basis == nullptr ? std::printf(" %10.3f", sample.*stage.seconds)
                     : std::printf(" %10.2f", speedup(*basis, sample, stage));
}

void print_case(const SpeedupCase& one) {
  std::printf("%s, h %.4g\n  %-20s", one.title().c_str(), one.size, "seconds");
  for (const StageKind& stage : kStages) std::printf(" %10s", stage.name);
  std::printf(" %10s\n", "B/tet");
  for (const StageWay& way : one.ways) {
    const StageSample sample = median_stages(way.samples);
    print_line(way.name().c_str(), sample, nullptr);
    std::printf(" %10.0f\n", static_cast<double>(sample.peak_bytes) / static_cast<double>(sample.tets));
  }
  for (const Basis basis : {Basis::OnePart, Basis::OneThread}) {
    const StageSample before = basis_of(one, basis);
    std::printf("  speed-up beside %s\n",
                basis == Basis::OnePart ? "the best run of 1 part, 1 thread" : "these parts on 1 thread");
    for (std::size_t i = 1; i < one.ways.size(); ++i) {
      print_line(one.ways[i].name().c_str(), median_stages(one.ways[i].samples), &before);
      std::printf("\n");
    }
  }
  const double serial = one.volume.serial_seconds();
  std::printf(
      "  volume on other numbers of threads: %zu tasks, %.1f %% of the stage not recorded and taken as serial\n",
      one.volume.records.size(), 100 * serial / one.volume.seconds);
  print_predictions(one.predictions);
  std::printf("\n");
}

Panel draw_speedup(const SpeedupCase& one, Basis basis, std::span<const int> threads) {
  const char* beside = basis == Basis::OnePart ? ", beside 1 part on 1 thread" : ", beside these parts on 1 thread";
  return speedup_panel(one.title() + beside, one.ways, basis_of(one, basis), kStages, threads, median_stages);
}

Panel draw_prediction(const SpeedupCase& one) {
  const double before = basis_of(one, Basis::OneThread).volume;
  return prediction_panel(one.title(), "volume", one.predictions,
                          measured_speedup(one.ways, before, median_stages, &StageSample::volume));
}

nlohmann::json to_json(const SpeedupCase& one) {
  nlohmann::json ways = nlohmann::json::array();
  for (const StageWay& way : one.ways)
    ways.push_back({{"task", way.task}, {"median", median_stages(way.samples)}, {"samples", way.samples}});
  return {{"size", one.size}, {"ways", ways}, {"prediction_of_volume", predictions_json(one.volume, one.predictions)}};
}

class Bench {
 public:
  explicit Bench(const Options& options) : options_(options), session_("volume_speedup", options.session) {
    options_.threads = compared_threads(std::move(options_.threads), session_.machine().cores);
  }

  void run() {
    session_.print_heading("no peer");
    const fs::path model = session_.model_path(options_.model);
    name_ = model.stem().string();
    for (const double tets : options_.tets) add_case(model, tets);
    for (SpeedupCase& one : cases_) measure(one);
    std::printf("%s\n%s\n", name_.c_str(), describe_prediction(options_.costs()).c_str());
    for (const SpeedupCase& one : cases_) print_case(one);
    write_json();
    if (!options_.session.svg_path.empty()) draw_speedups();
    if (!options_.prediction_path.empty()) draw_predictions();
  }

 private:
  void add_case(const fs::path& model, double tets) {
    VolumeTask task;
    task.model = model;
    SpeedupCase& one = cases_.emplace_back();
    one.wanted = tets;
    one.size = find_volume_size(session_.program(), task, tets);
    const std::string output = (session_.folder() / "mesh.vtu").string();
    one.ways.push_back({{model.string(), output, one.size, 1, true}});
    for (const int threads : options_.threads)
      one.ways.push_back({{model.string(), output, one.size, threads, false, options_.tets_per_part}});
  }

  void measure(SpeedupCase& one) {
    measure_ways(session_, name_ + ", h " + std::to_string(one.size), one.ways, [&](const StageTask& task) {
      touch_memory(memory_of(one));
      return measure_stages_apart(session_.program(), task);
    });
    record(one);
  }

  /// Bytes that a run needs, about.
  static std::uint64_t memory_of(const SpeedupCase& one) {
    constexpr double kBytesPerTet = 90;
    return static_cast<std::uint64_t>(kBytesPerTet * one.wanted);
  }

  void record(SpeedupCase& one) {
    StageTask task = one.ways[1].task;
    task.trace = options_.trace_path.empty() ? (session_.folder() / "trace.json").string() : options_.trace_path;
    touch_memory(memory_of(one));
    one.volume.seconds = measure_stages_apart(session_.program(), task).volume;
    one.volume.records = read_trace(task.trace);
    one.predictions = predict(one.volume, options_.workers, options_.costs());
  }

  void write_json() const {
    nlohmann::json cases = nlohmann::json::array();
    for (const SpeedupCase& one : cases_) {
      cases.push_back(to_json(one));
      cases.back()["model"] = name_;
    }
    session_.write_json(cases, "");
  }

  void draw_speedups() const {
    Figure figure = session_.make_figure("Speed-up by threads: " + name_, "from the CAD file to .vtu, per stage");
    for (const Basis basis : {Basis::OnePart, Basis::OneThread})
      for (const SpeedupCase& one : cases_) figure.panels.push_back(draw_speedup(one, basis, options_.threads));
    figure.columns = cases_.size();
    write_svg(figure, options_.session.svg_path);
  }

  void draw_predictions() const {
    Figure figure = session_.make_figure("PREDICTED speed-up of the volume stage by threads: " + name_,
                                         describe_prediction(options_.costs()));
    for (const SpeedupCase& one : cases_) figure.panels.push_back(draw_prediction(one));
    write_svg(figure, options_.prediction_path);
  }

  Options options_;
  Session session_;
  std::string name_;
  std::vector<SpeedupCase> cases_;
};

/// The tasks of any trace, such as one of partition_speed.
void replay_file(const Options& options) {
  RecordedStage stage{read_trace(options.replay_path), 0};
  stage.seconds = recorded_seconds(stage.records);
  std::printf("%s: %zu tasks, %.3f s\n%s\n", options.replay_path.c_str(), stage.records.size(), stage.seconds,
              describe_prediction(options.costs()).c_str());
  print_predictions(predict(stage, options.workers, options.costs()));
}

void add_options(CommandLine& line, Options& options) {
  line.add("--model", options.model, "a demo model or a CAD file");
  line.add("--tets", options.tets, "about how many tets").positive();
  line.add("--threads", options.threads, "numbers of threads; default: 1, 2, 4 ... and all cores").positive();
  line.add("--tets-per-part", options.tets_per_part, "of the volume; default: as the mesher sees fit").positive();
  line.add("--workers", options.workers, "numbers of threads for which the volume's speed is predicted").positive();
  line.add("--latency", options.latency_us, "of a message between parts in predictions, in microseconds")
      .not_negative();
  line.add("--bandwidth", options.bandwidth_gb, "of messages between parts in predictions, in GB/s").positive();
  line.add("--prediction", options.prediction_path, "draw predictions into this file");
  line.add("--trace", options.trace_path, "keep the tasks of the last recorded run, for a trace viewer");
  line.add("--replay", options.replay_path, "measure nothing, but predict from the tasks in this file").existing_file();
  add_session_options(line, options.session);
  add_plot_option(line, options.session);
}

int run(int argc, char** argv) {
  Options options;
  CommandLine line("Speed-up of meshing by threads, measured, and of its volume stage predicted", "volume_speedup");
  add_options(line, options);
  if (const auto status = line.parse(argc, argv)) return *status;
  if (!options.session.measure.empty()) {
    const StageTask task = nlohmann::json::parse(options.session.measure).get<StageTask>();
    std::puts(nlohmann::json(measure_stages_here(task)).dump().c_str());
    return 0;
  }
  if (!options.replay_path.empty()) return replay_file(options), 0;
  if (options.session.quick) {
    options.session.runs = 1;
    options.tets = {1e4, 2e4};
    options.tets_per_part = 3e3;
    options.threads = {1, 2};
  }
  Bench(options).run();
  return 0;
}

}  // namespace
}  // namespace tetloom::bench

int main(int argc, char** argv) { return tetloom::bench::run_bench("volume_speedup", tetloom::bench::run, argc, argv); }
