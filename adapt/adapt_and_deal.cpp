#include <algorithm>
#include <utility>

#include "adapt/adapt_together.hpp"
#include "adapt/conformity.hpp"
#include "adapt/result_check.hpp"
#include "tetloom/adapt.hpp"
#include "tetloom/partition.hpp"

namespace tetloom {

namespace {

using namespace adapt;

void check_result(const PartsWithMetric& parts, const SharedWork& work) {
  work.each([&] {
    for (const PartId part : parts.mesh.local()) {
      const PartMesh& mesh = parts.mesh.parts.at(part).mesh;
      check_positive({mesh.points.span(), adapt::tets_of(mesh)}, work.runner());
    }
  });
}

// The parts of the last round stay where they are as many as asked for, and nearly equal.
void deal(PartitionedMesh& mesh, std::size_t part_count, const SharedWork& work) {
  work.each([&] {
    work.runner().begin_stage(Stage::Partition, 0);
    work.runner().check_cancelled();
  });
  BalanceOptions options;
  options.part_count = part_count;
  if (part_count == mesh.part_count() && measure_parts(mesh).element_imbalance <= options.imbalance) return;
  deal_cells(mesh, options, work.runner());
}

// No rank has more of the result than its parts.
AdaptInPartsResult adapt_in_parts(const AdaptCall& call, Communicator& ranks, const Host& host) {
  AdaptInPartsResult result;
  const int asked = call.options.parts;
  result.run = guarded([&](AdaptResult& run) {
    const SharedWork work(std::max(0, call.options.threads), host, &ranks, call.options.trace);
    work.together([&] {
      adapt_together(call, work, run.report, [&](Adapter& adapter) {
        PartsWithMetric parts = adapter.take_parts();
        check_result(parts, work);
        run.report.after = conformity_of(parts, work);
        parts.to_metric = {};
        Stopwatch watch;
        deal(parts.mesh, asked > 0 ? static_cast<std::size_t>(asked) : parts.mesh.part_count(), work);
        result.partition_seconds = watch.lap();
        result.mesh = std::move(parts.mesh);
      });
    });
    result.mesh->communicator = &ranks;
  });
  if (result.run.status != AdaptStatus::Ok) result.mesh.reset();
  return result;
}

}  // namespace

AdaptInPartsResult adapt_mesh_in_parts(const Mesh& mesh, const adapt::MetricField& metric, const AdaptOptions& options,
                                       Communicator& ranks, const Host& host) {
  return adapt_in_parts({.options = options, .mesh = &mesh, .metric = &metric}, ranks, host);
}

AdaptInPartsResult adapt_mesh_in_parts(Mesh&& mesh, adapt::MetricField&& metric, const AdaptOptions& options,
                                       Communicator& ranks, const Host& host) {
  const AdaptCall call{
      .options = options, .mesh = &mesh, .metric = &metric, .mesh_given_up = &mesh, .metric_given_up = &metric};
  return adapt_in_parts(call, ranks, host);
}

AdaptInPartsResult adapt_mesh_in_parts(const Mesh& mesh, const std::function<adapt::Tensor(const Vec3&)>& metric,
                                       const AdaptOptions& options, Communicator& ranks, const Host& host) {
  return adapt_in_parts({.options = options, .mesh = &mesh, .function = metric}, ranks, host);
}

AdaptInPartsResult adapt_mesh_in_parts(PartitionedMesh&& mesh, PerPart<MetricField>&& metric,
                                       const AdaptOptions& options, const Host& host) {
  Communicator& ranks = *mesh.communicator;
  return adapt_in_parts({.options = options, .parts = &mesh, .parts_metric = &metric}, ranks, host);
}

AdaptInPartsResult adapt_mesh_in_parts(PartitionedMesh&& mesh, const std::function<Tensor(const Vec3&)>& metric,
                                       const AdaptOptions& options, const Host& host) {
  Communicator& ranks = *mesh.communicator;
  return adapt_in_parts({.options = options, .function = metric, .parts = &mesh}, ranks, host);
}

AdaptInPartsResult adapt_mesh_in_parts(PartitionedMesh&& mesh, const SolutionMetric& metric,
                                       const AdaptOptions& options, const Host& host) {
  Communicator& ranks = *mesh.communicator;
  return adapt_in_parts({.options = options, .parts = &mesh, .solution = &metric}, ranks, host);
}

}  // namespace tetloom
