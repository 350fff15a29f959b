#pragma once
// Where a surface mesh cannot have the sizes asked for: walls and faces much thinner than these, edges much shorter.
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "mesher/intersection/triangle_tree.hpp"
#include "tetloom/mesh_data.hpp"
#include "tetloom/model.hpp"
#include "tetloom/size_field.hpp"
#include "threading/comm/shared_work.hpp"

namespace tetloom {

/// A triangle on which the size does not fit, and one that does.
struct Misfit {
  std::uint32_t triangle = 0;
  double size = 0;  ///< model length, below the present size there; 0: none that is allowed
};

/// The smallest sizes that misfits may ask for at a place; model length.
struct SizeFloor {
  double usual = 0;
  double severe = 0;  ///< where the present size leaves angles of less than 5 degrees; at most the usual one
};

/// The largest width of a wall, of a face or of a model edge, in sizes, that calls for a smaller size. A single layer
/// of tets across a wall of this width has dihedral angles of 15 degrees and more (measured on plates: 14.7 at 0.3
/// sizes, 18.3 at 0.4, 9.4 at 0.2), and so have triangles across a face of this width.
inline constexpr double kLeastWidth = 0.4;

/// A new size is worth a new surface where it is smaller than the present one by this factor.
inline constexpr double kWorthwhileSize = 0.9;

/// Triangles that face another wall of the same region at less than kLeastWidth sizes, measured along their normal, and
/// triangles with an angle below 15 degrees and a height below that, in ascending order. Their size is what makes the
/// width or height kLeastWidth, but at least the usual floor of the place; what is narrower than .1 sizes gets .2, but
/// at least the severe floor.
///
/// On faces with layers, whose cells inherit the angles of their triangles, an angle below 22 degrees is too small; the
/// size makes the height .55 of it, down to the severe floor.
///
/// Not told are walls that meet at a common model edge, as in a wedge, and faces where they narrow between two model
/// edges that meet: smaller sizes would not make them any better. Beside corners the severe floor does not hold.
/// Widths below a tenth of the severe floor, which no size allowed fits, have size 0. Widths are sampled once per
/// triangle, at its centre, and at the middles of its sides that are pieces of model edges. `sizes`: those that the
/// mesh was made with. `tree`: of the mesh. `tri_is_new`: the triangles that are looked at; empty: all.
/// `face_has_layers`: per face; empty: none has. Complexity: O(n log n). Errors: Cancelled.
std::vector<Misfit> find_misfits(const Mesh& surface, const ModelTopology& topology, const SizeField& sizes,
                                 const std::function<SizeFloor(const Vec3&)>& floor,
                                 const intersection::TriangleTree& tree, const SharedWork& work,
                                 std::span<const std::uint8_t> tri_is_new = {},
                                 std::span<const std::uint8_t> face_has_layers = {});

/// Whether misfits are so few, less than a thousandth of the triangles, that they are not worth another surface: none
/// leaves angles of less than 5 degrees, or there are as many as the `before` that smaller sizes were made for.
/// `surface`, `sizes`: with which they were found.
bool are_negligible(const std::vector<Misfit>& misfits, const Mesh& surface, const SizeField& sizes,
                    std::size_t before);

}  // namespace tetloom
