#include "adapt/adapt_together.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "adapt/conformity.hpp"
#include "adapt/input_checks.hpp"
#include "adapt/touching_edges.hpp"
#include "core/base/free_memory.hpp"

namespace tetloom::adapt {

namespace {

void check_options(const AdaptOptions& options) {
  const auto refuse = [](const std::string& message) { throw Error(ErrorCode::InvalidArgument, message); };
  if (!(options.quality_floor >= 0 && options.quality_floor < 1)) refuse("the quality floor must be in [0, 1)");
  if (options.gradation != 0 && !(options.gradation > 1)) refuse("the gradation must be above 1, or 0 for none");
  if (options.threads < 0) refuse("the number of threads must not be negative");
  if (!(options.tets_per_part >= 0)) refuse("the number of tets per part must not be negative");
  if (options.parts < 0) refuse("the number of parts must not be negative");
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

MetricField metric_of(const AdaptCall& call, const TaskRunner& runner) {
  if (call.metric_given_up) return std::move(*call.metric_given_up);
  return call.metric ? *call.metric : metric_from_function(call.function, call.mesh.points, runner);
}

// The metric asked for at the points of the mesh, limited as the options say.
MetricField prepare_metric(const AdaptCall& call, const TaskRunner& runner, AdaptReport& report) {
  const Mesh& mesh = call.mesh;
  const AdaptOptions& options = call.options;
  check_options(options);
  check_mesh(mesh, runner);
  check_transfer(mesh, options.transfer);
  MetricField metric = metric_of(call, runner);
  check_metric(metric, mesh);
  if (!call.metric) return metric;
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
  const AdaptLoad load{before.complexity, static_cast<double>(mesh.tet_to_vert.size()), work.rank_count(),
                       work.ranks().ranks_on_machine()};
  work.each([&] { check_load(load); });
  return before;
}

// The mesh without edges at which it touches itself, and the metric there; nothing where it has none.
std::optional<RefinedInput> split_touching(const AdaptCall& call, const MetricField& metric, double complexity,
                                           const TaskRunner& runner) {
  constexpr double kMostOfTouching = 2;  // times the tets that the metric asks for
  const double most = static_cast<double>(call.mesh.tet_to_vert.size()) + kMostOfTouching * expected_tets(complexity);
  auto refined =
      split_touching_edges(call.mesh, metric, call.function, call.options.model, static_cast<std::size_t>(most));
  // Errors name elements of the mesh that was given.
  if (refined) make_whole_mesh(call.mesh, runner);
  return refined;
}

// Many ranks on a machine have no room for what each of them might need again.
void give_back_where_shared(const SharedWork& work) {
  if (work.rank_count() > 1) give_back_free_memory();
}

}  // namespace

void adapt_together(const AdaptCall& call, const SharedWork& work, AdaptReport& report,
                    const std::function<void(Adapter&)>& finish) {
  Stopwatch watch;
  MetricField metric;
  give_back_where_shared(work);
  work.each([&] { metric = prepare_metric(call, work.runner(), report); });
  give_back_where_shared(work);
  require_same_input(call.mesh, metric, call.options, work);
  report.before = conformity_before(call.mesh, metric, work);
  give_back_where_shared(work);
  std::optional<RefinedInput> refined;
  std::optional<Adapter> adapter;
  work.each([&] {
    refined = split_touching(call, metric, report.before.complexity, work.runner());
    AdapterInput input = refined ? AdapterInput{refined->mesh, &refined->mesh, std::move(refined->metric)}
                                 : AdapterInput{call.mesh, call.mesh_given_up, std::move(metric)};
    adapter.emplace(std::move(input), call.function, call.options, work);
  });
  metric = MetricField();
  give_back_where_shared(work);
  adapter->spread();
  give_back_where_shared(work);
  report.stages.set_up = watch.lap();
  adapter->run(report);
  watch.lap();
  finish(*adapter);
  report.stages.result += watch.lap();
}

}  // namespace tetloom::adapt
