#pragma once
// One task carried out in one part and in parts on numbers of threads, beside each other: what benches of speed-ups
// have in common. A Task has `threads` and `one_part`, a Sample a `digest`, a Stage a `name` and the member `seconds`
// of a Sample.
#include <span>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "bench/support/session.hpp"
#include "bench/support/speedup_plot.hpp"

namespace tetloom::bench {

/// The runs of one task.
template <class Task, class Sample>
struct Way {
  Task task;
  std::vector<Sample> samples = {};

  std::string name() const {
    return (task.one_part ? "1 part, " : "parts, ") + std::to_string(task.threads) +
           (task.threads == 1 ? " thread" : " threads");
  }
};

/// Runs all ways in turns: measure(task). The first one is in one part. `title` is for the log. Throws
/// std::runtime_error where parts do not give the same mesh in all runs, or one part does not.
template <class AnyWay, class Measure>
void measure_ways(const Session& session, const std::string& title, std::vector<AnyWay>& ways, const Measure& measure) {
  const auto title_of = [&](const AnyWay& way) { return title + ", " + way.name(); };
  session.take_turns(std::span(ways), title_of, [&](AnyWay& way, int) { way.samples.push_back(measure(way.task)); });
  for (const AnyWay& way : ways)
    for (const auto& sample : way.samples)
      if (sample.digest != (way.task.one_part ? ways[0] : ways[1]).samples.front().digest)
        throw std::runtime_error(title_of(way) + ": not the mesh that other runs gave");
}

/// 0 where a stage takes no time that can be told.
template <class Sample, class Stage>
double speedup(const Sample& before, const Sample& after, const Stage& stage) {
  constexpr double kShortest = 1e-4;
  return after.*stage.seconds > kShortest ? before.*stage.seconds / (after.*stage.seconds) : 0;
}

/// How many times as fast as `before` each stage is in parts, by threads. median(samples) is the sample that counts.
template <class AnyWay, class Sample, class Stages, class Median>
Panel speedup_panel(const std::string& title, const std::vector<AnyWay>& ways, const Sample& before,
                    const Stages& stages, std::span<const int> threads, const Median& median) {
  Panel panel{title, thread_axis(threads, "threads"), {"times as fast"}, {}};
  for (const auto& stage : stages) {
    PlotSeries series{stage.name, {}};
    for (std::size_t i = 1; i < ways.size(); ++i)
      if (const double times = speedup(before, median(ways[i].samples), stage); times > 0)
        series.points.push_back({static_cast<double>(ways[i].task.threads), times});
    panel.series.push_back(std::move(series));
  }
  panel.series.push_back(ideal_speedup(threads));
  return panel;
}

/// The same of one member of the samples, beside the `before` seconds of parts on one thread.
template <class AnyWay, class Median, class Seconds>
std::vector<PlotPoint> measured_speedup(const std::vector<AnyWay>& ways, double before, const Median& median,
                                        const Seconds& seconds) {
  std::vector<PlotPoint> points;
  for (std::size_t i = 1; i < ways.size(); ++i)
    points.push_back({static_cast<double>(ways[i].task.threads), before / (median(ways[i].samples).*seconds)});
  return points;
}

}  // namespace tetloom::bench
