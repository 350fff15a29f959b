// The claims: a mesh is led to a metric 1.8 times as fast on 2 threads as on one, the parts cost at most 1.15 times the
// time of one part on one thread, and it takes no more than 160 bytes per tet. What the tasks of a run would give on up
// to 64 threads is predicted from them, and says so.
#include <algorithm>
#include <cstdio>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include <nlohmann/json.hpp>

#include "bench/support/adapt_cases.hpp"
#include "bench/support/adapt_run.hpp"
#include "bench/support/cube.hpp"
#include "bench/support/prediction.hpp"
#include "bench/support/session.hpp"
#include "bench/support/speedup_plot.hpp"
#include "bench/support/trace_file.hpp"
#include "bench/support/ways.hpp"

namespace tetloom::bench {
namespace {

struct Options {
  std::vector<std::string> cases = adapt_case_names();
  std::string input, write, prediction_path, trace_path;
  std::vector<int> threads;  ///< empty: 1, 2, 4 ... and all cores
  double tets_per_part = 0;
  std::vector<int> workers = {1, 2, 4, 8, 16, 32, 64};
  SessionOptions session;
};

using AdaptWay = Way<AdaptTask, AdaptSample>;

double bytes_per_tet(const AdaptWay& way) {
  return static_cast<double>(way.samples.front().peak_bytes) / static_cast<double>(way.samples.front().most_tets());
}

/// `ways`: one part on one thread, then parts on each number of threads, one first.
struct SpeedupCase {
  AdaptCase what;
  std::vector<AdaptWay> ways = {};
  RecordedStage recorded = {};  ///< parts on one thread
  std::vector<Prediction> predictions = {};

  double tets() const { return static_cast<double>(ways[1].samples.front().tets_made()); }
  std::string title() const {
    char text[64];
    std::snprintf(text, sizeof(text), "%s, %.3g M tets", what.name.c_str(), 1e-6 * tets());
    return text;
  }
};

void print_fit(const AdaptWay& way) {
  const AdaptSample& sample = way.samples.front();
  const Fit fit = worst_of(sample.fits);
  std::printf(
      "  %-20s %4zu rounds, %zu parts; unit %.2f %%, edges %.3f to %.3f, mean ratio %.4f on average, at least %.4f\n",
      way.name().c_str(), static_cast<std::size_t>(sample.rounds), static_cast<std::size_t>(sample.most_parts),
      100 * fit.unit, fit.shortest, fit.longest, fit.mean_quality, fit.least_quality);
}

void print_case(const SpeedupCase& one) {
  std::printf("%s\n", one.title().c_str());
  print_fit(one.ways[0]), print_fit(one.ways[1]);
  std::printf("  %-20s", "seconds");
  for (const AdaptStage& stage : kAdaptStages) std::printf(" %8s", stage.name);
  std::printf(" %10s %6s\n", "k tets/s", "B/tet");
  for (const AdaptWay& way : one.ways) {
    const AdaptSample sample = median_adapt(way.samples);
    std::printf("  %-20s", way.name().c_str());
    for (const AdaptStage& stage : kAdaptStages) std::printf(" %8.3f", sample.*stage.seconds);
    std::printf(" %10.1f %6.0f\n", 1e-3 * static_cast<double>(sample.tets_made()) / sample.whole, bytes_per_tet(way));
  }
  const AdaptSample before = median_adapt(one.ways[1].samples);
  std::printf("  speed-up beside these parts on 1 thread\n");
  for (std::size_t i = 2; i < one.ways.size(); ++i) {
    const AdaptSample after = median_adapt(one.ways[i].samples);
    std::printf("  %-20s", one.ways[i].name().c_str());
    for (const AdaptStage& stage : kAdaptStages) std::printf(" %8.2f", speedup(before, after, stage));
    std::printf("\n");
  }
  std::printf("  parts take %.2f times as long as 1 part, on 1 thread\n",
              before.whole / median_adapt(one.ways[0].samples).whole);
  std::printf("  on other numbers of threads: %zu tasks, %.1f %% of the run not recorded and taken as serial\n",
              one.recorded.records.size(), 100 * one.recorded.serial_seconds() / one.recorded.seconds);
  print_predictions(one.predictions);
  std::printf("\n");
}

Panel draw_speedup(const SpeedupCase& one, std::span<const int> threads) {
  return speedup_panel(one.title(), one.ways, median_adapt(one.ways[1].samples), kAdaptStages, threads, median_adapt);
}

Panel draw_prediction(const SpeedupCase& one) {
  const double before = median_adapt(one.ways[1].samples).whole;
  return prediction_panel(one.title(), "whole", one.predictions,
                          measured_speedup(one.ways, before, median_adapt, &AdaptSample::whole));
}

nlohmann::json to_json(const SpeedupCase& one) {
  nlohmann::json ways = nlohmann::json::array();
  for (const AdaptWay& way : one.ways)
    ways.push_back({{"task", way.task},
                    {"median", median_adapt(way.samples)},
                    {"samples", way.samples},
                    {"bytes_per_tet", bytes_per_tet(way)}});
  return {{"case", one.what.name},
          {"metrics", one.what.metrics},
          {"ways", ways},
          {"prediction", predictions_json(one.recorded, one.predictions)}};
}

/// "PREFIX-case.meshb"; nothing without a prefix.
std::string mesh_path(const std::string& prefix, const std::string& name) {
  if (prefix.empty()) return "";
  std::string tail = name;
  std::replace_if(
      tail.begin(), tail.end(), [](char c) { return c == ':' || c == ',' || c == '*' || c == '/'; }, '_');
  return prefix + "-" + tail + ".meshb";
}

class Bench {
 public:
  explicit Bench(const Options& options) : options_(options), session_("adapt_speedup", options.session) {
    options_.threads = compared_threads(std::move(options_.threads), session_.machine().cores);
  }

  void run() {
    session_.print_heading("no peer");
    const std::string input = options_.input.empty() ? make_cube(session_).string() : options_.input;
    for (const std::string& name : options_.cases) add_case(name, input);
    for (SpeedupCase& one : cases_) measure(one);
    std::printf("%s\n", describe_prediction({}).c_str());
    for (const SpeedupCase& one : cases_) print_case(one);
    write_json();
    if (!options_.session.svg_path.empty()) draw_speedups();
    if (!options_.prediction_path.empty()) draw_predictions();
  }

 private:
  void add_case(const std::string& name, const std::string& input) {
    SpeedupCase& one = cases_.emplace_back();
    one.what = find_adapt_case(name);
    one.ways.push_back({{input, one.what.metrics, 1, true}});
    for (const int threads : options_.threads)
      one.ways.push_back({{input, one.what.metrics, threads, false, options_.tets_per_part}});
  }

  void measure(SpeedupCase& one) {
    measure_ways(session_, one.what.name, one.ways,
                 [&](const AdaptTask& task) { return measure_adapt_apart(session_.program(), task); });
    record(one);
  }

  void record(SpeedupCase& one) {
    AdaptTask task = one.ways[1].task;
    task.trace = options_.trace_path.empty() ? (session_.folder() / "trace.json").string() : options_.trace_path;
    task.write = mesh_path(options_.write, one.what.name);
    one.recorded.seconds = measure_adapt_apart(session_.program(), task).whole;
    one.recorded.records = read_trace(task.trace);
    one.predictions = predict(one.recorded, options_.workers, {});
  }

  void write_json() const {
    nlohmann::json cases = nlohmann::json::array();
    for (const SpeedupCase& one : cases_) cases.push_back(to_json(one));
    session_.write_json(cases, "");
  }

  void draw_speedups() const {
    Figure figure = session_.make_figure("Speed-up of adaptation by threads", "per stage, the same parts on 1 thread");
    for (const SpeedupCase& one : cases_) figure.panels.push_back(draw_speedup(one, options_.threads));
    figure.columns = std::min<std::size_t>(cases_.size(), 3);
    write_svg(figure, options_.session.svg_path);
  }

  void draw_predictions() const {
    Figure figure = session_.make_figure("PREDICTED speed-up of adaptation by threads", describe_prediction({}));
    for (const SpeedupCase& one : cases_) figure.panels.push_back(draw_prediction(one));
    figure.columns = std::min<std::size_t>(cases_.size(), 3);
    write_svg(figure, options_.prediction_path);
  }

  Options options_;
  Session session_;
  std::vector<SpeedupCase> cases_;
};

/// Each case once, to look at its figures or its mesh.
void run_once(const Options& options, int threads) {
  const Session session("adapt_speedup", options.session);
  session.print_heading("no peer");
  const std::string input = options.input.empty() ? make_cube(session).string() : options.input;
  for (const std::string& name : options.cases) {
    const AdaptCase one = find_adapt_case(name);
    AdaptWay way{{input, one.metrics, threads, false, options.tets_per_part, "", mesh_path(options.write, name)}};
    way.samples.push_back(measure_adapt_apart(session.program(), way.task));
    const AdaptSample& sample = way.samples.front();
    std::printf("%s: %.3f s, %.1f k tets/s, %zu tets, %.0f B/tet\n", name.c_str(), sample.whole,
                1e-3 * static_cast<double>(sample.tets_made()) / sample.whole,
                static_cast<std::size_t>(sample.fits.back().tets), bytes_per_tet(way));
    print_fit(way);
    std::fflush(stdout);
  }
}

void add_options(CommandLine& line, Options& options, int& once) {
  line.add("--cases", options.cases, "iso, cube-linear, polar-2, shock, moving-shock, or metrics such as iso:0.05")
      .separated_by(';');
  line.add("--input", options.input, "a mesh of tets to begin with; default: the unit cube in 10 thousand tets")
      .existing_file();
  line.add("--threads", options.threads, "numbers of threads; default: 1, 2, 4 ... and all cores").positive();
  line.add("--tets-per-part", options.tets_per_part, "default: as adaptation sees fit").positive();
  line.add("--workers", options.workers, "numbers of threads for which the speed is predicted").positive();
  line.add("--once", once, "run each case once on so many threads, and compare nothing").positive();
  line.add("--write", options.write, "keep the meshes, as PREFIX-CASE.meshb");
  line.add("--prediction", options.prediction_path, "draw predictions into this file");
  line.add("--trace", options.trace_path, "keep the tasks of the last recorded run, for a trace viewer");
  add_session_options(line, options.session);
  add_plot_option(line, options.session);
}

int run(int argc, char** argv) {
  Options options;
  int once = 0;
  CommandLine line("Speed-up of adaptation by threads, measured and predicted", "adapt_speedup");
  add_options(line, options, once);
  if (const auto status = line.parse(argc, argv)) return *status;
  if (!options.session.measure.empty()) {
    const AdaptTask task = nlohmann::json::parse(options.session.measure).get<AdaptTask>();
    std::puts(nlohmann::json(measure_adapt_here(task)).dump().c_str());
    return 0;
  }
  if (options.session.quick || once > 0) options.session.runs = 1;
  if (once > 0) return run_once(options, once), 0;
  if (options.session.quick) {
    options.cases = quick_adapt_case_names();
    options.tets_per_part = 5e3;
    options.threads = {1, 2};
  }
  Bench(options).run();
  return 0;
}

}  // namespace
}  // namespace tetloom::bench

int main(int argc, char** argv) { return tetloom::bench::run_bench("adapt_speedup", tetloom::bench::run, argc, argv); }
