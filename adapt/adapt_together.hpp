#pragma once
// One adaptation from its input to what is to be handed back, by one process or by ranks together.
#include <functional>

#include "adapt/adapter.hpp"
#include "core/base/failure.hpp"
#include "core/base/stopwatch.hpp"
#include "tetloom/partition.hpp"
#include "threading/comm/shared_work.hpp"

namespace tetloom::adapt {

/// What adapt_mesh is called with: a mesh that all ranks have, or one in parts.
struct AdaptCall {
  const AdaptOptions& options;
  const Mesh* mesh = nullptr;           ///< null: there are parts
  const MetricField* metric = nullptr;  ///< at the points; null: there are parts, or a function
  MetricFunction function = {};
  Mesh* mesh_given_up = nullptr;           ///< `mesh`, where nobody needs it any more
  MetricField* metric_given_up = nullptr;  ///< `metric`, the same
  PartitionedMesh* parts = nullptr;        ///< emptied
  PerPart<MetricField>* parts_metric = nullptr;
  const SolutionMetric* solution = nullptr;  ///< of a mesh in parts, instead of a metric or a function
};

/// Checks what is given, adapts, and calls `finish`, which takes the mesh. In SharedWork::together. Errors: as those of
/// adapt_mesh_on_ranks.
void adapt_together(const AdaptCall& call, const SharedWork& work, AdaptReport& report,
                    const std::function<void(Adapter&)>& finish);

/// Calls run(result), and notes what it throws, and how long it takes.
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

}  // namespace tetloom::adapt
