#pragma once
// Pyramids, prisms and hexahedra of second order: bounds of their Jacobian. Tets have curved_tet.hpp.
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

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

/// A cell of a mesh of second order by its vertices.
CurvedCell curved_cell_of(const Mesh& mesh, const MidNodes& mids, CellKind kind, std::span<const std::uint32_t> verts);

/// The determinant of the Jacobian of the map from the reference cell, as a polynomial on a cube: its Bézier
/// coefficients, u fastest, over the least that the straight cell has at a corner. Where that is not positive they are
/// all minus infinity.
///
/// As for tets bounds are least coefficients (Johnen, Remacle & Geuzaine 2013), here of tensor products: a prism and a
/// pyramid are cubes with an edge or a face drawn together, and the factor by which the determinant vanishes there is
/// divided out beforehand. Coefficients come from sampled values.
struct CellJacobian {
  std::vector<double> coefficients;
  std::array<std::size_t, 3> counts{};  ///< along u, v and w
  double volume = 0;                    ///< of the cell, exact but for rounding
};

CellJacobian cell_jacobian(const CurvedCell& cell);

/// A lower bound of the polynomial on the cell: at least `enough`, or within .001 of the least value that was found,
/// which then is less.
double least_jacobian(const CellJacobian& jacobian, double enough);

/// Whether it is proven to be positive everywhere.
bool has_positive_jacobian(const CellJacobian& jacobian);

}  // namespace tetloom
