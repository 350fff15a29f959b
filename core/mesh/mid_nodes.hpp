#pragma once
// Meshes of second order: the edges of elements, and the mid nodes on them.
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/mesh/mesh_access.hpp"
#include "tetloom/host.hpp"
#include "tetloom/mesh_data.hpp"

namespace tetloom {

/// Two vertices of an element by their places in it.
using LocalEdge = std::array<std::uint8_t, 2>;
inline constexpr std::array<LocalEdge, 1> kLineEdges{{{0, 1}}};
inline constexpr std::array<LocalEdge, 3> kTriangleEdges{{{0, 1}, {1, 2}, {2, 0}}};
inline constexpr std::array<LocalEdge, 4> kQuadEdges{{{0, 1}, {1, 2}, {2, 3}, {3, 0}}};

/// Calls visit(x_to_vert, local edges) for edges, surface elements and cells.
template <class Visit>
void for_each_edge_owner(const Mesh& mesh, const Visit& visit) {
  visit(mesh.edge_to_vert, std::span<const LocalEdge>(kLineEdges));
  visit(mesh.tri_to_vert, std::span<const LocalEdge>(kTriangleEdges));
  visit(mesh.quad_to_vert, std::span<const LocalEdge>(kQuadEdges));
  for_each_cell_kind(mesh,
                     [&](CellKind kind, const auto& cells, const auto&) { visit(cells, shape_of(kind).edges()); });
}

/// How many of the points are vertices. Pre: there are no more mid nodes than points.
inline std::size_t vertex_count(const Mesh& mesh) { return mesh.points.size() - mesh.mid_to_vert.size(); }

/// The middle between the ends of the edge at a place in `mid_to_vert`.
inline Vec3 middle_of_edge(const Mesh& mesh, std::size_t mid) {
  const auto [a, b] = mesh.mid_to_vert[mid];
  return 0.5 * (mesh.points[a] + mesh.points[b]);
}

/// All edges of all elements once, the lower end first, ascending: the `mid_to_vert` of a mesh of second order.
/// Pre: require_consistent(mesh). Linear but for sorting around each vertex; 4 bytes per edge of each element.
std::vector<std::array<std::uint32_t, 2>> edges_of_elements(const Mesh& mesh, const BlockLoop& loop = serial_loop());

/// Finds mid nodes by the ends of their edges. 4 bytes per vertex.
class MidNodes {
 public:
  /// `mesh` outlives the object, and its mid nodes stay where they are.
  explicit MidNodes(const Mesh& mesh);

  bool empty() const { return edges_.empty(); }
  /// The place in `mid_to_vert` of the edge between two vertices; kNone where it has no mid node.
  std::uint32_t find(std::uint32_t a, std::uint32_t b) const {
    const std::uint32_t low = std::min(a, b), high = std::max(a, b);
    if (low + std::size_t{1} >= begins_.size()) return kNone;
    std::uint32_t first = begins_[low], last = begins_[low + 1];
    while (first < last) {
      const std::uint32_t middle = first + (last - first) / 2;
      if (edges_[middle][1] < high)
        first = middle + 1;
      else
        last = middle;
    }
    return first < begins_[low + 1] && edges_[first][1] == high ? first : kNone;
  }
  /// The same as an index of a point. Pre: the edge has a mid node.
  std::uint32_t point(std::uint32_t a, std::uint32_t b) const { return vertices_ + find(a, b); }

 private:
  std::span<const std::array<std::uint32_t, 2>> edges_;
  std::uint32_t vertices_;
  std::vector<std::uint32_t> begins_;  // by lower end
};

/// The mid nodes of a cell as places in `mid_to_vert`, in the order of its edges.
class CellMids {
 public:
  /// Pre: the mesh of `mids` is of second order and has the cell.
  CellMids(CellKind kind, std::span<const std::uint32_t> verts, const MidNodes& mids);

  std::size_t size() const { return count_; }
  std::uint32_t operator[](std::size_t i) const { return mids_[i]; }
  const std::uint32_t* begin() const { return mids_.data(); }
  const std::uint32_t* end() const { return mids_.data() + count_; }

 private:
  std::array<std::uint32_t, 12> mids_;
  std::size_t count_ = 0;
};

/// By vertex: whether an edge is bent that ends there, its mid node beside the middle. An element with fewer than two
/// such vertices is straight.
std::vector<std::uint8_t> ends_of_bent_edges(const Mesh& mesh);

/// Whether an element has two vertices that are marked with 1, and so may have an edge between such.
template <class Verts>
bool has_two_of(const Verts& verts, std::span<const std::uint8_t> marks) {
  int marked = 0;
  for (const std::uint32_t v : verts) marked += marks[v];
  return marked >= 2;
}

/// What is wrong with the mid nodes of a mesh whose elements refer to points that are there; nothing where they are as
/// `Mesh` says, or where there are none.
std::optional<std::string> find_mid_node_fault(const Mesh& mesh, const BlockLoop& loop = serial_loop());

/// Gives every mid node the entity of the elements at its edge that have the lowest dimension: the lowest
/// region, or that of the first element on the surface. Pre: a mesh of second order without faults, whose points have
/// entities, the mid nodes invalid ones.
void classify_mid_nodes(Mesh& mesh, const BlockLoop& loop = serial_loop());

/// Leaves a mesh of first order: takes away mid nodes, and the values of fields on them.
void drop_mid_nodes(Mesh& mesh);

}  // namespace tetloom
