#pragma once
// What a mesh in parts is as a whole, on all ranks.
#include <vector>

#include "tetloom/partition.hpp"
#include "threading/comm/shared_work.hpp"

namespace tetloom {

/// The mesh of gather_mesh on every rank. `mesh` is emptied part after part: beside its parts a rank holds the whole
/// mesh twice at most, and one part more. In SharedWork::together. Errors: OutOfMemory, Cancelled.
Mesh copy_to_all(PartitionedMesh&& mesh, const SharedWork& work);

/// The names and components of its fields, without values.
Mesh fields_of(const PartitionedMesh& mesh);

/// The model entities of all parts, ascending, each as the lowest part has it that has it. In together.
std::vector<PartEntity> gather_entities(const PartitionedMesh& mesh, const SharedWork& work);

}  // namespace tetloom
