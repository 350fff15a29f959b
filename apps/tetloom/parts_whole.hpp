#pragma once
// What is said of a mesh in parts as a whole.
#include <functional>

#include "apps/tetloom/report.hpp"
#include "tetloom/partition.hpp"
#include "tetloom/tasks.hpp"
#include "threading/parts/parts_summary.hpp"

namespace tetloom::app {

/// Notes counts and digest of the whole mesh, on the first rank; without triangles and digest where it is too large to
/// be brought together. `look`, where there is one, sees the whole mesh, on the first rank too, and has the threads of
/// all ranks beside it, which wait. A collective call.
void note_whole(const PartitionedMesh& mesh, const PartsFigures& figures, const TaskRunner& runner, RunReport& report,
                const std::function<void(const Mesh&, const TaskRunner&)>& look = {});

/// Notes counts, quality and digest of the whole mesh, which nobody has to hold.
void note_summary(const PartsSummary& summary, const PartsFigures& figures, RunReport& report);

}  // namespace tetloom::app
