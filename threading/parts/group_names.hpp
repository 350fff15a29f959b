#pragma once
// The groups that files for solvers have of a mesh in parts, under the names that they have of the whole mesh.
#include "core/io/solver/groups.hpp"
#include "tetloom/partition.hpp"

namespace tetloom::detail {

/// The groups and the entities of a whole mesh.
struct GroupNames {
  Groups groups;  ///< without elements
  EntityTable entities;
};

/// The same on all ranks. A collective call. Errors: those of the communicator.
GroupNames gather_group_names(const PartitionedMesh& mesh);

}  // namespace tetloom::detail
