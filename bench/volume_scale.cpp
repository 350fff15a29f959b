// The claim: 300 million tets of a CAD model are meshed and written to disk on one machine, in time and memory that
// grow no faster than the mesh. The command runs as a user would run it, in a process of its own, and is measured from
// outside.
#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <span>
#include <stdexcept>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "bench/support/pipeline_run.hpp"
#include "bench/support/session.hpp"
#include "bench/support/volume_run.hpp"

namespace tetloom::bench {
namespace {

struct Options {
  std::string model = "spline-block";
  std::vector<double> tets = {1e6, 5e6, 20e6};
  int threads = 0;
  std::string format, max_memory;
  SessionOptions session;
};

struct ScaleCase {
  PipelineTask task;
  double wanted = 0;  ///< tets, about
  PipelineSeries series;
};

void print_table(std::span<const ScaleCase> cases) {
  std::printf("%10s %9s  %8s %8s %8s %8s %8s  %10s  %8s %7s %8s %8s\n", "M tets", "h", "whole s", "sizes s",
              "surface s", "volume s", "write s", "k tets/s", "peak GB", "B/tet", "swap GB", "file GB");
  for (const ScaleCase& one : cases) {
    if (one.series.empty()) {
      std::printf("%10.3f %9.5g  failed: %s\n", 1e-6 * one.wanted, one.task.size, one.series.failure.c_str());
      continue;
    }
    const PipelineSample& s = one.series.median();
    std::printf("%10.3f %9.5g  %8.2f %8.2f %8.2f %8.2f %8.2f  %10.0f  %8.2f %7.1f %8.2f %8.2f\n",
                1e-6 * static_cast<double>(s.tets), one.task.size, s.seconds, s.size_field, s.surface, s.volume,
                s.write, 1e-3 * static_cast<double>(s.tets) / s.seconds, 1e-9 * static_cast<double>(s.peak_bytes),
                s.bytes_per_tet(), 1e-9 * static_cast<double>(s.swap_bytes), 1e-9 * static_cast<double>(s.file_bytes));
  }
}

struct Quantity {
  const char* name;
  double (*value)(const PipelineSample&);
};

Panel draw_panel(const char* title, Axis axis, std::span<const ScaleCase> cases, std::span<const Quantity> quantities) {
  Panel panel{title, {"tets", Scale::Log}, std::move(axis), {}};
  for (const Quantity& quantity : quantities) {
    PlotSeries series{quantity.name, {}};
    for (const ScaleCase& one : cases) {
      if (one.series.empty()) continue;
      const PipelineSample& sample = one.series.median();
      if (const double value = quantity.value(sample); value > 0)
        series.points.push_back({static_cast<double>(sample.tets), value});
    }
    std::sort(series.points.begin(), series.points.end(),
              [](const PlotPoint& a, const PlotPoint& b) { return a.x < b.x; });
    if (!series.points.empty()) panel.series.push_back(std::move(series));
  }
  return panel;
}

constexpr Quantity kSeconds[] = {{"whole process", [](const PipelineSample& s) { return s.seconds; }},
                                 {"size field", [](const PipelineSample& s) { return s.size_field; }},
                                 {"surface", [](const PipelineSample& s) { return s.surface; }},
                                 {"volume", [](const PipelineSample& s) { return s.volume; }},
                                 {"write", [](const PipelineSample& s) { return s.write; }}};
constexpr Quantity kBytes[] = {
    {"peak memory", [](const PipelineSample& s) { return 1e-9 * static_cast<double>(s.peak_bytes); }},
    {"swapped out", [](const PipelineSample& s) { return 1e-9 * static_cast<double>(s.swap_bytes); }},
    {"file", [](const PipelineSample& s) { return 1e-9 * static_cast<double>(s.file_bytes); }}};

class Bench {
 public:
  explicit Bench(const Options& options) : options_(options), session_("volume_scale", options.session) {
    if (options_.threads == 0) options_.threads = session_.machine().cores;
    if (options_.format.empty()) options_.format = command_writes("pvtu") ? "pvtu" : "vtu";
  }

  void run() {
    session_.print_heading("the command alone, writing ." + options_.format);
    const std::filesystem::path model = session_.model_path(options_.model);
    name_ = model.stem().string();
    for (const double tets : options_.tets) {
      const double size = find_volume_size(session_.program(), {model}, tets);
      cases_.push_back(
          {{model, session_.folder() / ("mesh." + options_.format), size, options_.threads, options_.max_memory},
           tets,
           {}});
    }
    const auto title = [&](const ScaleCase& one) { return name_ + ", h " + std::to_string(one.task.size); };
    session_.take_turns(std::span(cases_), title, [&](ScaleCase& one, int) { measure(one); });
    std::printf("%s, %d threads\n", name_.c_str(), options_.threads);
    print_table(cases_);
    write_json();
    if (!options_.session.svg_path.empty()) draw();
    if (std::all_of(cases_.begin(), cases_.end(), [](const ScaleCase& one) { return one.series.empty(); }))
      throw std::runtime_error("no mesh was made");
  }

 private:
  /// A mesh that is too large for the machine is told of, and the others count.
  static void measure(ScaleCase& one) {
    try {
      one.series.samples.push_back(run_command(one.task));
      if (one.series.samples.back().digest != one.series.samples.front().digest)
        throw std::logic_error("not the mesh that the first run gave");
    } catch (const std::runtime_error& error) {
      one.series.failure = error.what();
    }
  }

  void write_json() const {
    nlohmann::json cases = nlohmann::json::array();
    for (const ScaleCase& one : cases_)
      cases.push_back({{"model", name_},
                       {"size", one.task.size},
                       {"threads", one.task.threads},
                       {"format", options_.format},
                       {"failure", one.series.failure},
                       {"samples", one.series.samples}});
    session_.write_json(cases, "");
  }

  void draw() const {
    if (std::all_of(cases_.begin(), cases_.end(), [](const ScaleCase& one) { return one.series.empty(); })) return;
    Figure figure = session_.make_figure(
        "Tets against time and memory: " + name_,
        std::to_string(options_.threads) + " threads, the command from the CAD file to ." + options_.format);
    constexpr Quantity kPerTet[] = {{"peak memory", [](const PipelineSample& s) { return s.bytes_per_tet(); }}};
    figure.panels = {draw_panel("Time", {"seconds", Scale::Log}, cases_, kSeconds),
                     draw_panel("Memory and disk", {"GB", Scale::Log}, cases_, kBytes),
                     draw_panel("Memory per tet", {"bytes per tet"}, cases_, kPerTet)};
    write_svg(figure, options_.session.svg_path);
  }

  Options options_;
  Session session_;
  std::string name_;
  std::vector<ScaleCase> cases_;
};

int run(int argc, char** argv) {
  Options options;
  CommandLine line("Tets against time and memory, from a CAD file to a mesh on disk. Files go to $TMPDIR.",
                   "volume_scale");
  line.add("--model", options.model, "a demo model or a CAD file");
  line.add("--tets", options.tets, "about how many tets").positive();
  line.add("--threads", options.threads, "default: all cores").positive();
  line.add("--format", options.format, "extension of the mesh; default: pvtu where the command writes it, else vtu");
  line.add("--max-memory", options.max_memory, "the command's option of that name");
  add_session_options(line, options.session);
  add_plot_option(line, options.session);
  if (const auto status = line.parse(argc, argv)) return *status;
  if (options.session.quick) {
    options.session.runs = 1;
    options.tets = {1e4, 4e4};
  }
  Bench(options).run();
  return 0;
}

}  // namespace
}  // namespace tetloom::bench

int main(int argc, char** argv) { return tetloom::bench::run_bench("volume_scale", tetloom::bench::run, argc, argv); }
