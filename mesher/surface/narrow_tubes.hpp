#pragma once
// Tubes thinner than the sizes of their mesh.
#include <cstdint>

#include "mesher/surface/patch.hpp"

namespace tetloom {

/// Whether two triangles of the patch meet in the edge, and it may be split.
inline bool is_inner_edge(const Triangulation& topology, std::uint32_t h) {
  return topology.twin(h) != Triangulation::kNone && !topology.fixed(h);
}

/// Puts a vertex into the middle of an edge.
void split_in_middle(Patch& patch, const PatchSurface& surface, std::uint32_t h);

/// Where sizes are larger than the girth of a tube, edges may run around it from a node of its seam to the same node:
/// their triangles would be lost, and the tube with them. Puts vertices into the middle of these, and then of edges
/// that join the same two vertices, so that four are left around the tube. Changes nothing where no edge runs around.
void open_narrow_tubes(Patch& patch, const PatchSurface& surface);

}  // namespace tetloom
