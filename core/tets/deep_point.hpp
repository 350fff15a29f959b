#pragma once
// The place in a star from which all its faces are seen best.
#include <optional>
#include <span>

#include "core/tets/star_tet.hpp"
#include "tetloom/vec.hpp"

namespace tetloom::tets {

/// A point inside of a star, and how far from its faces.
struct DeepPoint {
  Vec3 point;  ///< measured from where the star was measured
  double depth =
      0;  ///< the least distance from the planes of the star's faces; 0 or less: some are not seen from inside
};

/// An affine function of a place: offset + dot(slope, x).
struct AffineFunction {
  Vec3 slope;
  double offset = 0;
};

/// The place where the least of `functions` is nearly as large as it gets (within a tenth), and that value, or a place
/// where it is not positive when it is so nowhere; nothing where there are fewer than four functions, or all are 0 at
/// the origin. `functions` are changed. A linear program in four unknowns, by Newton's method along the central path of
/// its logarithmic barrier (Boyd & Vandenberghe 2004, 11.3), which starts at the origin. O(functions) times some twenty
/// steps. Pre: their least has an upper bound.
std::optional<DeepPoint> maximize_least(std::span<AffineFunction> functions);

/// Where that distance is nearly as large as it gets (within a tenth), for the faces opposite to the star's vertex; a
/// place where it is not positive when there is none where it is. Faces without area do not count; nothing where fewer
/// than four have some. The tets may be flat or inverted. By `maximize_least`. Pre: the faces bound a closed
/// polyhedron, and are no more than twice WorkingMesh::kMostTets.
std::optional<DeepPoint> find_deep_point(std::span<const StarTet> star);

}  // namespace tetloom::tets
