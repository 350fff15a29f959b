#pragma once
// Tets of second order: bounds of their Jacobian.
#include <array>
#include <cstddef>
#include <cstdint>

#include "core/mesh/mid_nodes.hpp"
#include "tetloom/mesh_data.hpp"
#include "tetloom/vec.hpp"

namespace tetloom {

/// The four vertices and the six mid nodes of a tet, in the order of kCellShapes.
using TetNodes = std::array<Vec3, 10>;

/// The determinant of the Jacobian of the map from the straight tet of the same vertices, as a polynomial of degree 3:
/// its Bézier coefficients, of which the first four are its values at the vertices. 1 throughout for a straight tet.
using TetJacobian = std::array<double, 20>;

/// Nodes of tet `t` of a mesh of second order.
TetNodes nodes_of_tet(const Mesh& mesh, const MidNodes& mids, std::size_t t);

/// Whether all mid nodes of tet `t` lie in the middle of their edges, to the last bit.
bool is_straight_tet(const Mesh& mesh, const MidNodes& mids, std::size_t t);

/// Exact but for rounding (Johnen, Remacle & Geuzaine 2013, whose coefficients come from sampled values; these are sums
/// of products of control points). Not finite where the straight tet is flat.
TetJacobian tet_jacobian(const TetNodes& nodes);

/// The same without division: six times the volume throughout for a straight tet. Where the mid nodes of the edges at a
/// vertex stay in their middles, all coefficients are affine in the place of this vertex.
TetJacobian tet_determinant(const TetNodes& nodes);

/// A lower bound of the polynomial on the tet: at least `enough`, or within .001 of the least value that was found
/// there, which then is less. Halves the tet where the bound of the coefficients is not sharp enough.
double least_jacobian(const TetJacobian& jacobian, double enough);

/// Whether the Jacobian of tet `t` is proven to be positive everywhere.
bool has_positive_jacobian(const Mesh& mesh, const MidNodes& mids, std::size_t t);

/// The mean of the polynomial over the tet: the volume in units of that of the straight tet.
double mean_jacobian(const TetJacobian& jacobian);

}  // namespace tetloom
