#pragma once
// Tubes thinner than the sizes of their mesh.
#include <array>
#include <compare>
#include <cstdint>
#include <vector>

#include "mesher/surface/patch.hpp"

namespace tetloom {

/// Whether two triangles of the patch meet in the edge, and it may be split.
inline bool is_inner_edge(const Triangulation& topology, std::uint32_t h) {
  return topology.twin(h) != Triangulation::kNone && !topology.fixed(h);
}

/// An edge by the names of its ends, ascending: a node's number, whichever of its places it is, or kInnerVertex | index
/// of a vertex that is no node.
struct NamedEdge {
  static constexpr std::uint32_t kInnerVertex = 0x80000000u;
  std::array<std::uint32_t, 2> ends{};
  std::uint32_t h = 0;
  friend auto operator<=>(const NamedEdge&, const NamedEdge&) = default;
};

/// The name of one side's half-edge.
NamedEdge named_edge(const Patch& patch, std::uint32_t h);

/// Inner edges, one side each, between two vertices that another edge joins too; ascending by names.
std::vector<NamedEdge> find_edges_alike(const Patch& patch);

/// Puts a vertex into the middle of an edge.
void split_in_middle(Patch& patch, const PatchSurface& surface, std::uint32_t h);

/// Where sizes are larger than the girth of a tube, edges may run around it from a node of its seam to the same node:
/// their triangles would be lost, and the tube with them. Puts vertices into the middle of these, and then of edges
/// that join the same two vertices, until there are none: four around the tube. Changes nothing where no edge runs
/// around.
void open_narrow_tubes(Patch& patch, const PatchSurface& surface);

}  // namespace tetloom
