#pragma once
// Pyramids, prisms and hexahedra of second order: bounds of their Jacobian. Tets have curved_tet.hpp.
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "core/mesh/mid_nodes.hpp"
#include "tetloom/mesh_data.hpp"
#include "tetloom/vec.hpp"

namespace tetloom {

/// The vertices of a cell, and how far its mid nodes lie from the middles of their edges, in the order of kCellShapes.
/// The map from the reference cell is that of the nodes that files hold: serendipity functions of 15 nodes for prisms
/// and 20 for hexahedra, the 13 rational ones of Bedrosian (1992) for pyramids.
struct CurvedCell {
  CellKind kind = CellKind::Prism;
  std::array<Vec3, 8> verts{};
  std::array<Vec3, 12> bends{};

  std::size_t edge_count() const { return shape_of(kind).edge_count; }
  /// Whether all mid nodes lie in the middle of their edges, to the last bit.
  bool is_straight() const;
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

/// A cell of a mesh of second order by its vertices.
CurvedCell curved_cell_of(const Mesh& mesh, const MidNodes& mids, CellKind kind, std::span<const std::uint32_t> verts);

/// A lower bound of the determinant of the Jacobian over the cell, divided by the least that the straight cell has at a
/// corner: at least `enough`, or within .001 of the least value that was found, which then is less. Minus infinity
/// where the straight cell has a corner that is not positive.
///
/// As for tets the bound is the least Bézier coefficient (Johnen, Remacle & Geuzaine 2013), here of tensor products: a
/// prism and a pyramid are cubes with an edge or a face drawn together, and the factor by which the determinant
/// vanishes there is divided out beforehand. Coefficients come from sampled values.
double least_jacobian(const CurvedCell& cell, double enough);

/// Whether the Jacobian is proven to be positive everywhere.
bool has_positive_jacobian(const CurvedCell& cell);

/// Exact but for rounding.
double volume_of(const CurvedCell& cell);

}  // namespace tetloom
