#pragma once
// The executable invariant of a partitioned mesh.
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "threading/partitioned_mesh.hpp"

namespace tetloom {

/// All problems of one sort in one part.
struct PartProblem {
  PartId part;
  std::string message;        ///< one sentence
  std::uint64_t count = 0;    ///< how many there are
  std::optional<Vec3> point;  ///< at the first of them
};

struct PartsReport {
  std::vector<PartProblem> problems;  ///< of the parts of this rank, ascending by part
  std::uint64_t total = 0;            ///< problems on all ranks
  bool valid() const { return total == 0; }
};

/// Checks that arrays fit together; that neighbours inside a part name each other at the same face, and vertices name
/// corners of their own; that global ids are distinct within a part; that the copies listed for every shared
/// vertex are exactly the parts that have its global id; that links of vertices, edges and faces name each other from
/// both sides, and agree in global ids, coordinates and classification; that every face without a cell behind it is
/// either shared with exactly one part, where nothing is behind it either, or, in meshes with boundary elements, a
/// boundary element. So a mesh that passes, made of a conforming mesh, is one. Cells' volumes are left to
/// validate_mesh.
///
/// A collective call; never throws for a bad mesh. Linear in the cells, messages only between neighbours and for
/// finding global ids.
PartsReport validate_parts(PartitionedMesh& mesh, const TaskRunner& runner, Trace* trace = nullptr);

}  // namespace tetloom
