#include "threading/parts/idle_ranks.hpp"

#include <algorithm>

#include "tetloom/tasks.hpp"

namespace tetloom {

TaskRunner runner_for_cells(const PartitionedMesh& mesh, const TaskRunner& runner) {
  const bool has_cells =
      std::ranges::any_of(mesh.local(), [&](PartId part) { return mesh.parts.at(part).mesh.cell_count() > 0; });
  std::array<std::int64_t, 1> holders{has_cells ? 1 : 0};
  mesh.communicator->sum(holders);
  return runner.with_idle_threads(has_cells && holders[0] == 1 ? mesh.communicator->ranks_on_machine() : 1);
}

}  // namespace tetloom
