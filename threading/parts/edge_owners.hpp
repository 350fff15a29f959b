#pragma once
// Which part measures an edge of a mesh in parts: its owner, whether that has an element at it or not.
#include <cstdint>
#include <vector>

#include "core/mesh/quality_values.hpp"
#include "tetloom/partition.hpp"
#include "tetloom/tasks.hpp"

namespace tetloom {

/// Every edge of the tets and of the triangles of a mesh, once in all parts. The owner of an edge may have no tet at it
/// where there are other cells, and no triangle; so parts tell owners of theirs. Immutable.
class EdgeOwners {
 public:
  /// A collective call. Errors: OutOfMemory.
  EdgeOwners(const PartitionedMesh& mesh, const TaskRunner& runner);

  /// Those of a part of this rank, by its vertices. Refers to the part.
  MeasuredEdges of(const Part& part, PartId self) const;

 private:
  using Places = PerPart<std::vector<std::uint32_t>>;  // in PartBoundary::edges of the parts that own them, ascending
  Places of_tets_, of_triangles_;
};

}  // namespace tetloom
