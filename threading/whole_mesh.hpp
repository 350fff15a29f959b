#pragma once
// Between a mesh in one piece and a mesh in parts.
#include "core/mesh/mesh.hpp"
#include "threading/partitioned_mesh.hpp"

namespace tetloom {

/// `mesh` as part 0 of a mesh in one part, which lives on rank 0; what the other ranks give is not looked at. A
/// collective call. Errors: those of make_part, on all ranks.
PartitionedMesh distribute_mesh(const Mesh& mesh, Communicator& communicator);

/// Moves all cells to part 0 of one part. A collective call; errors as for migrate.
void gather_in_one_part(PartitionedMesh& mesh, const TaskRunner& runner);

/// The whole mesh on rank 0, and an empty one on the others. Points stand by global id; cells by part, then in the
/// order of their part. A collective call; takes the memory of the whole mesh, several times over, on rank 0.
Mesh gather_mesh(const PartitionedMesh& mesh, const TaskRunner& runner);

}  // namespace tetloom
