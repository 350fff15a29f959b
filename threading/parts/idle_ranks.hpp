#pragma once
// Threads for a rank that works while the others of its machine wait for it.
#include "tetloom/partition.hpp"
#include "tetloom/tasks.hpp"

namespace tetloom {

/// For work on the cells of `mesh`: where they all lie on this rank, the threads of all ranks on its machine, as far as
/// this process may use their cores (mpirun --bind-to none); else those of `runner`. A collective call.
TaskRunner runner_for_cells(const PartitionedMesh& mesh, const TaskRunner& runner);

}  // namespace tetloom
