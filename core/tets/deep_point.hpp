#pragma once
// The place in a star from which all its faces are seen best.
#include <optional>
#include <span>

#include "core/tets/star_tet.hpp"
#include "tetloom/vec.hpp"

namespace tetloom::tets {

struct DeepPoint {
  Vec3 point;  ///< measured from where the star was measured
  double depth =
      0;  ///< the least distance from the planes of the star's faces; 0 or less: some are not seen from inside
};

/// Where that distance is nearly as large as it gets (within a tenth), for the faces opposite to the star's vertex; a
/// place where it is not positive when there is none where it is. Faces without area do not count; nothing where fewer
/// than four have some. The tets may be flat or inverted. A linear program in four unknowns, by Newton's method along
/// the central path of its logarithmic barrier (Boyd & Vandenberghe 2004, 11.3). O(faces) times some twenty steps.
/// Pre: the faces bound a closed polyhedron, and are no more than twice WorkingMesh::kMostTets.
std::optional<DeepPoint> find_deep_point(std::span<const StarTet> star);

}  // namespace tetloom::tets
