#pragma once
// The dihedral angles of a tet.
#include <cstdint>

#include "core/tets/tet_mesh.hpp"

namespace tetloom::tets {

/// The smallest dihedral angle of a tet: between faces `face` and `other`.
struct Dihedral {
  double angle = 0;  ///< radians
  std::uint32_t face = 0, other = 1;
};

/// The angle between two faces of a tet, radians.
double dihedral_between(const TetMesh& mesh, std::uint32_t tet, std::uint32_t face, std::uint32_t other);

Dihedral smallest_dihedral(const TetMesh& mesh, std::uint32_t tet);

/// The cosine of the smallest dihedral angle of the tet (a, b, c, d).
double cosine_of_smallest_dihedral(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d);

/// False only where smallest_dihedral is at least the angle of this cosine: a quick look at tets most of which have
/// larger angles.
bool may_be_below(const TetMesh& mesh, std::uint32_t tet, double cosine);

/// No tet whose smallest dihedral angle is `angle` (radians, at most that of the regular tet) has a larger cubed
/// quality than this: 2 sin^2(angle), found numerically. The best ones have two nearly equilateral faces at that angle;
/// over sin^2 their cubed quality falls from 2 for flat ones to 9/8 for the regular tet.
double largest_quality_with_dihedral(double angle);

}  // namespace tetloom::tets
