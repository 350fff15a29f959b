#include "bench/support/adapt_run.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

#include "bench/support/adapt_cases.hpp"
#include "bench/support/child_process.hpp"
#include "bench/support/machine.hpp"
#include "core/base/stopwatch.hpp"
#include "tetloom/adapt.hpp"
#include "tetloom/check.hpp"
#include "tetloom/io.hpp"

namespace tetloom::bench {
namespace {

Fit fit_of(const MetricConformity& conformity, const Mesh& mesh) {
  return {mesh.tet_to_vert.size(),  conformity.edges,        conformity.unit,
          conformity.half_to_two,   conformity.shortest,     conformity.longest,
          conformity.least_quality, conformity.mean_quality, conformity.complexity};
}

void add(const AdaptReport& report, AdaptSample& sample) {
  sample.set_up += report.stages.set_up;
  sample.metric += report.stages.metric;
  sample.dealing += report.stages.dealing;
  sample.parts += report.stages.parts;
  sample.result += report.stages.result;
  sample.whole += report.seconds;
  sample.rounds += report.rounds;
  sample.most_parts = std::max<std::uint64_t>(sample.most_parts, report.most_parts);
}

}  // namespace

std::uint64_t AdaptSample::tets_made() const {
  std::uint64_t sum = 0;
  for (const Fit& fit : fits) sum += fit.tets;
  return sum;
}

std::uint64_t AdaptSample::most_tets() const {
  std::uint64_t most = 0;
  for (const Fit& fit : fits) most = std::max(most, fit.tets);
  return most;
}

Fit worst_of(const std::vector<Fit>& fits) {
  Fit worst = fits.at(0);
  for (const Fit& fit : fits) {
    worst.tets = std::max(worst.tets, fit.tets), worst.edges = std::max(worst.edges, fit.edges);
    worst.unit = std::min(worst.unit, fit.unit), worst.half_to_two = std::min(worst.half_to_two, fit.half_to_two);
    worst.shortest = std::min(worst.shortest, fit.shortest), worst.longest = std::max(worst.longest, fit.longest);
    worst.least_quality = std::min(worst.least_quality, fit.least_quality);
    worst.mean_quality = std::min(worst.mean_quality, fit.mean_quality);
    worst.complexity = std::max(worst.complexity, fit.complexity);
  }
  return worst;
}

AdaptSample measure_adapt_here(const AdaptTask& task) {
  Trace trace;
  AdaptOptions options;
  options.threads = task.threads;
  options.tets_per_part = task.one_part ? HUGE_VAL : task.tets_per_part;
  options.trace = task.trace.empty() ? nullptr : &trace;
  AdaptSample sample;
  Stopwatch watch;
  Mesh mesh = read_mesh(task.input);
  sample.read = watch.lap();
  for (const std::string& metric : task.metrics) {
    AdaptResult adapted = adapt_mesh(mesh, analytic_metric(metric), options);
    if (adapted.status != AdaptStatus::Ok) throw Error(adapted.errors.at(0));
    mesh = std::move(adapted.mesh);
    add(adapted.report, sample);
    sample.fits.push_back(fit_of(adapted.report.after, mesh));
  }
  sample.peak_bytes = peak_resident_bytes();
  sample.digest = mesh_digest(mesh);
  watch.lap();
  if (!task.write.empty()) write_mesh(mesh, task.write);
  sample.write = watch.lap();
  if (options.trace != nullptr) trace.write(task.trace);
  return sample;
}

AdaptSample measure_adapt_apart(const std::string& program, const AdaptTask& task) {
  constexpr std::uint64_t kMemory = 500'000'000;  // more than a million tets need
  touch_memory(kMemory);
  const ChildResult child = run_child({program, "--measure", nlohmann::json(task).dump()});
  if (child.exit_status != 0) throw std::runtime_error("adapting '" + task.input + "' failed: " + child.output);
  return nlohmann::json::parse(child.output).get<AdaptSample>();
}

AdaptSample median_adapt(const std::vector<AdaptSample>& samples) {
  AdaptSample median = samples.front();
  for (const AdaptStage& stage : kAdaptStages) {
    std::vector<double> values;
    for (const AdaptSample& sample : samples) values.push_back(sample.*stage.seconds);
    std::sort(values.begin(), values.end());
    median.*stage.seconds = values[(values.size() - 1) / 2];
  }
  return median;
}

Fit judge_fit_here(const FitTask& task) {
  Mesh mesh = read_mesh(task.mesh);
  const adapt::MetricField metric = adapt::metric_from_function(analytic_metric(task.metric), mesh.points);
  const Fit fit = fit_of(measure_conformity(mesh, metric), mesh);
  if (!task.solution.empty()) {
    MeshField field = field_of_metric(metric, adapt::TensorOrder::Medit);
    if (task.sizes && task.metric.starts_with("iso:")) {
      std::vector<double> sizes;
      for (std::size_t v = 0; v < metric.size(); ++v) sizes.push_back(1 / std::sqrt(metric.at(v).xx));
      field = {"size", 1, std::move(sizes)};
    }
    write_solution({{std::move(field)}, {}}, solution_size(mesh), task.solution);
  }
  if (!task.copy.empty()) {
    mesh.edge_to_vert.clear(), mesh.edge_to_entity.clear();
    write_mesh(mesh, task.copy);
  }
  return fit;
}

Fit judge_fit_apart(const std::string& program, const FitTask& task) {
  const ChildResult child = run_child({program, "--measure", nlohmann::json(task).dump()});
  if (child.exit_status != 0) throw std::runtime_error("judging '" + task.mesh + "' failed: " + child.output);
  return nlohmann::json::parse(child.output).get<Fit>();
}

}  // namespace tetloom::bench
