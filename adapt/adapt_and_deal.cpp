#include <utility>

#include "core/base/stopwatch.hpp"
#include "tetloom/adapt.hpp"
#include "tetloom/partition.hpp"
#include "tetloom/tasks.hpp"
#include "threading/comm/shared_work.hpp"

namespace tetloom {

namespace {

PartitionedMesh deal(Mesh&& whole, std::size_t part_count, Communicator& ranks, const TaskRunner& runner) {
  run_on_all(ranks, [&] {
    runner.begin_stage(Stage::Partition, 0);
    runner.check_cancelled();
  });
  PartitionedMesh mesh = distribute_mesh(whole, ranks);
  whole = Mesh();
  deal_cells(mesh, {.part_count = part_count, .weights = {}}, runner);
  return mesh;
}

template <class Metric>
AdaptInPartsResult adapt_and_deal(const Mesh& mesh, const Metric& metric, const AdaptOptions& options,
                                  Communicator& ranks, const Host& host) {
  AdaptInPartsResult result;
  result.run = adapt_mesh_on_ranks(mesh, metric, options, ranks, host);
  if (result.run.status != AdaptStatus::Ok) return result;
  Stopwatch watch;
  const std::size_t parts = options.parts > 0 ? static_cast<std::size_t>(options.parts) : result.run.report.last_parts;
  const auto failure = failure_of([&] {
    const SharedWork work(options.threads, host, &ranks);
    work.together([&] { result.mesh = deal(std::move(result.run.mesh), parts, work.ranks(), work.runner()); });
    result.mesh->communicator = &ranks;
  });
  if (failure) {
    result.run.status = failure->code == ErrorCode::Cancelled ? AdaptStatus::Cancelled : AdaptStatus::Failed;
    result.run.errors.push_back(*failure);
    result.run.mesh = Mesh();
    result.mesh.reset();
  }
  result.partition_seconds = watch.lap();
  return result;
}

}  // namespace

AdaptInPartsResult adapt_mesh_in_parts(const Mesh& mesh, const adapt::MetricField& metric, const AdaptOptions& options,
                                       Communicator& ranks, const Host& host) {
  return adapt_and_deal(mesh, metric, options, ranks, host);
}

AdaptInPartsResult adapt_mesh_in_parts(const Mesh& mesh, const std::function<adapt::Tensor(const Vec3&)>& metric,
                                       const AdaptOptions& options, Communicator& ranks, const Host& host) {
  return adapt_and_deal(mesh, metric, options, ranks, host);
}

}  // namespace tetloom
