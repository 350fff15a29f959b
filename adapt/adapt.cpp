#include "tetloom/adapt.hpp"

#include <algorithm>
#include <cmath>

#include "adapt/adapter.hpp"
#include "adapt/conformity.hpp"
#include "adapt/input_checks.hpp"
#include "adapt/result_check.hpp"
#include "adapt/touching_edges.hpp"
#include "core/base/failure.hpp"
#include "core/base/stopwatch.hpp"
#include "tetloom/tasks.hpp"
#include "threading/comm/codec.hpp"

namespace tetloom {

namespace {

using namespace adapt;

void check_options(const AdaptOptions& options) {
  const auto refuse = [](const std::string& message) { throw Error(ErrorCode::InvalidArgument, message); };
  if (!(options.quality_floor >= 0 && options.quality_floor < 1)) refuse("the quality floor must be in [0, 1)");
  if (options.gradation != 0 && !(options.gradation > 1)) refuse("the gradation must be above 1, or 0 for none");
  if (options.threads < 0) refuse("the number of threads must not be negative");
  if (!(options.tets_per_part >= 0)) refuse("the number of tets per part must not be negative");
  if (options.parts < 0) refuse("the number of parts must not be negative");
}

template <class Run>
AdaptResult guarded(const Run& run) {
  AdaptResult result;
  Stopwatch watch;
  const std::optional<Diagnostic> failure = failure_of([&] { run(result); });
  if (!failure) {
    result.status = AdaptStatus::Ok;
  } else {
    result.errors.push_back(*failure);
    result.status = failure->code == ErrorCode::Cancelled ? AdaptStatus::Cancelled : AdaptStatus::Failed;
    result.mesh = Mesh();
  }
  result.report.seconds = watch.lap();
  return result;
}

// What ranks give differs where they read different files, say; it would leave them waiting for each other.
void require_same_input(const Mesh& mesh, const MetricField& metric, const AdaptOptions& options,
                        const SharedWork& work) {
  if (work.rank_count() == 1) return;
  std::uint64_t own = 0;
  work.each([&] { own = fingerprint(mesh, metric, options, work.runner()); });
  for (const Bytes& bytes : work.all_gather([&](MessageWriter& writer) { writer.put(own); }))
    if (MessageReader(bytes).get<std::uint64_t>() != own)
      throw Error(ErrorCode::InvalidArgument, "the ranks were not given the same mesh, metric and options");
}

void put_findings(const AdaptReport& report, MessageWriter& writer) {
  writer.put(report.after);
  writer.put(static_cast<std::uint64_t>(report.transfers.size()));
  for (const FieldTransfer& field : report.transfers) {
    put_text(writer, field.name);
    writer.put(field.on_cells);
    writer.put_array(std::span<const FieldTransfer::Component>(field.components));
  }
}

// What rank 0 has found out about the mesh, for all.
void share_findings(AdaptReport& report, const SharedWork& work) {
  const std::vector<Bytes> given = work.all_gather([&](MessageWriter& writer) { put_findings(report, writer); });
  if (work.rank() == 0) return;
  MessageReader reader(given[0]);
  report.after = reader.get<MetricConformity>();
  report.transfers.resize(reader.get<std::uint64_t>());
  for (FieldTransfer& field : report.transfers) {
    field.name = get_text(reader);
    field.on_cells = reader.get<bool>();
    field.components = reader.get_array<FieldTransfer::Component>();
  }
}

// The metric asked for at the points of the mesh, limited as the options say.
MetricField prepare_metric(const Mesh& mesh, const MetricField* given, const MetricFunction& function,
                           const AdaptOptions& options, const TaskRunner& runner, AdaptReport& report) {
  check_options(options);
  check_mesh(mesh, runner);
  check_transfer(mesh, options.transfer);
  MetricField metric = given ? *given : metric_from_function(function, mesh.points, runner);
  check_metric(metric, mesh);
  if (!given) return metric;
  const TetView view{mesh.points, mesh.tet_to_vert};
  if (options.gradation > 0) limit_gradation(metric, mesh.points, VertexGraph(view, runner), options.gradation, runner);
  report.turning = limit_turning(metric, view, runner);
  return metric;
}

// Found on the first rank, for all.
MetricConformity conformity_before(const Mesh& mesh, const MetricField& metric, const SharedWork& work) {
  MetricConformity before;
  work.each([&] {
    if (work.rank() == 0) before = measure_conformity(mesh, metric, work.runner_for_one());
  });
  const auto given = work.all_gather([&](MessageWriter& writer) { writer.put(before); });
  if (work.rank() != 0) before = MessageReader(given[0]).get<MetricConformity>();
  work.each([&] { check_complexity(before.complexity); });
  return before;
}

// The mesh without edges at which it touches itself, and the metric there; nothing where it has none.
std::optional<RefinedInput> split_touching(const Mesh& mesh, const MetricField& metric, const MetricFunction& function,
                                           const AdaptOptions& options, double complexity, const TaskRunner& runner) {
  constexpr double kMostOfTouching = 2;  // times the tets that the metric asks for
  const double most = static_cast<double>(mesh.tet_to_vert.size()) + kMostOfTouching * expected_tets(complexity);
  auto refined = split_touching_edges(mesh, metric, function, options.model, static_cast<std::size_t>(most));
  // Errors name elements of the mesh that was given.
  if (refined) make_whole_mesh(mesh, runner);
  return refined;
}

// On the first rank, which has the mesh.
void check_result(AdaptResult& result, std::span<const VertexMetric> metric, const SharedWork& work) {
  work.each([&] {
    if (work.rank() != 0) return;
    check_positive(result.mesh, work.runner_for_one());
    result.report.after = conformity_of(result.mesh, metric, work.runner_for_one());
  });
  share_findings(result.report, work);
}

void adapt_together(const Mesh& mesh, const MetricField* given, const MetricFunction& function,
                    const AdaptOptions& options, const SharedWork& work, AdaptResult& result) {
  Stopwatch watch;
  AdaptReport& report = result.report;
  MetricField metric;
  work.each([&] { metric = prepare_metric(mesh, given, function, options, work.runner(), report); });
  require_same_input(mesh, metric, options, work);
  report.before = conformity_before(mesh, metric, work);
  std::optional<RefinedInput> refined;
  std::optional<Adapter> adapter;
  work.each([&] {
    refined = split_touching(mesh, metric, function, options, report.before.complexity, work.runner());
    adapter.emplace(refined ? refined->mesh : mesh, refined ? refined->metric : metric, function, options, work);
  });
  report.stages.set_up = watch.lap();
  adapter->run(result);
  watch.lap();
  check_result(result, adapter->metric_of_result(), work);
  report.stages.result += watch.lap();
}

AdaptResult adapt_to(const Mesh& mesh, const MetricField* given, const MetricFunction& function,
                     const AdaptOptions& options, Communicator* ranks, const Host& host) {
  return guarded([&](AdaptResult& result) {
    const SharedWork work(std::max(0, options.threads), host, ranks, options.trace);
    work.together([&] { adapt_together(mesh, given, function, options, work, result); });
  });
}

}  // namespace

AdaptResult adapt_mesh(const Mesh& mesh, const MetricField& metric, const AdaptOptions& options, const Host& host) {
  return adapt_to(mesh, &metric, {}, options, nullptr, host);
}

AdaptResult adapt_mesh(const Mesh& mesh, const std::function<Tensor(const Vec3&)>& metric, const AdaptOptions& options,
                       const Host& host) {
  return adapt_to(mesh, nullptr, metric, options, nullptr, host);
}

AdaptResult adapt_mesh_on_ranks(const Mesh& mesh, const MetricField& metric, const AdaptOptions& options,
                                Communicator& ranks, const Host& host) {
  return adapt_to(mesh, &metric, {}, options, &ranks, host);
}

AdaptResult adapt_mesh_on_ranks(const Mesh& mesh, const std::function<Tensor(const Vec3&)>& metric,
                                const AdaptOptions& options, Communicator& ranks, const Host& host) {
  return adapt_to(mesh, nullptr, metric, options, &ranks, host);
}

}  // namespace tetloom
