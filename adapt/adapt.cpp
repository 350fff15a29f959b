#include "tetloom/adapt.hpp"

#include <algorithm>

#include "adapt/adapt_together.hpp"
#include "adapt/conformity.hpp"
#include "adapt/result_check.hpp"

namespace tetloom {

namespace {

using namespace adapt;

// What rank 0 has found out about the mesh, for all.
void share_findings(AdaptReport& report, const SharedWork& work) {
  const std::vector<Bytes> given = work.all_gather([&](MessageWriter& writer) { writer.put(report.after); });
  report.after = MessageReader(given[0]).get<MetricConformity>();
}

// On the first rank, which has the mesh.
void finish_whole(Adapter& adapter, AdaptResult& result, const SharedWork& work) {
  Adapter::Whole whole = adapter.take_whole();
  work.each([&] {
    if (work.rank() != 0) return;
    check_positive(tets_of(whole.mesh), work.runner_for_one());
    result.report.after = conformity_of(whole.mesh, whole.metric.span(), work.runner_for_one());
  });
  result.mesh = std::move(whole.mesh);
  share_findings(result.report, work);
}

AdaptResult adapt_to(const AdaptCall& call, Communicator* ranks, const Host& host) {
  return guarded([&](AdaptResult& result) {
    const SharedWork work(std::max(0, call.options.threads), host, ranks, call.options.trace);
    work.together([&] {
      adapt_together(call, work, result.report, [&](Adapter& adapter) { finish_whole(adapter, result, work); });
    });
  });
}

}  // namespace

AdaptResult adapt_mesh(const Mesh& mesh, const MetricField& metric, const AdaptOptions& options, const Host& host) {
  return adapt_to({.options = options, .mesh = &mesh, .metric = &metric}, nullptr, host);
}

AdaptResult adapt_mesh(const Mesh& mesh, const std::function<Tensor(const Vec3&)>& metric, const AdaptOptions& options,
                       const Host& host) {
  return adapt_to({.options = options, .mesh = &mesh, .function = metric}, nullptr, host);
}

AdaptResult adapt_mesh_on_ranks(const Mesh& mesh, const MetricField& metric, const AdaptOptions& options,
                                Communicator& ranks, const Host& host) {
  return adapt_to({.options = options, .mesh = &mesh, .metric = &metric}, &ranks, host);
}

AdaptResult adapt_mesh_on_ranks(Mesh&& mesh, MetricField&& metric, const AdaptOptions& options, Communicator& ranks,
                                const Host& host) {
  const AdaptCall call{
      .options = options, .mesh = &mesh, .metric = &metric, .mesh_given_up = &mesh, .metric_given_up = &metric};
  return adapt_to(call, &ranks, host);
}

AdaptResult adapt_mesh_on_ranks(const Mesh& mesh, const std::function<Tensor(const Vec3&)>& metric,
                                const AdaptOptions& options, Communicator& ranks, const Host& host) {
  return adapt_to({.options = options, .mesh = &mesh, .function = metric}, &ranks, host);
}

AdaptResult adapt_mesh_on_ranks(PartitionedMesh&& mesh, PerPart<MetricField>&& metric, const AdaptOptions& options,
                                const Host& host) {
  Communicator& ranks = *mesh.communicator;
  return adapt_to({.options = options, .parts = &mesh, .parts_metric = &metric}, &ranks, host);
}

AdaptResult adapt_mesh_on_ranks(PartitionedMesh&& mesh, const std::function<Tensor(const Vec3&)>& metric,
                                const AdaptOptions& options, const Host& host) {
  Communicator& ranks = *mesh.communicator;
  return adapt_to({.options = options, .function = metric, .parts = &mesh}, &ranks, host);
}

AdaptResult adapt_mesh_on_ranks(PartitionedMesh&& mesh, const SolutionMetric& metric, const AdaptOptions& options,
                                const Host& host) {
  Communicator& ranks = *mesh.communicator;
  return adapt_to({.options = options, .parts = &mesh, .solution = &metric}, &ranks, host);
}

}  // namespace tetloom
