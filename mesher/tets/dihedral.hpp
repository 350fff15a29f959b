#pragma once
// The dihedral angles of a tet, and what the surface leaves of them.
#include <array>
#include <cstddef>
#include <cstdint>

#include "mesher/tets/working_mesh.hpp"

namespace tetloom::tets {

/// The smallest dihedral angle of a tet: between faces `face` and `other`.
struct Dihedral {
  double angle = 0;  ///< radians
  std::uint32_t face = 0, other = 1;
};

Dihedral smallest_dihedral(const TetMesh& mesh, std::uint32_t tet);

/// No tet whose smallest dihedral angle is `angle` (radians, at most that of the regular tet) has a larger cubed
/// quality than this: 2 sin^2(angle), found numerically. The best ones have two nearly equilateral faces at that angle;
/// over sin^2 their cubed quality falls from 2 for flat ones to 9/8 for the regular tet.
double largest_quality_with_dihedral(double angle);

/// Whether the surface leaves a tet with so small an angle little choice: the angle is between two faces that have to
/// stay; or the tet has such a face of mean ratio (of triangles) below 1/2; or two points of the surface are its
/// vertices and nearer to each other than a third of its longest edge.
bool is_forced(const WorkingMesh& mesh, std::uint32_t tet, const Dihedral& dihedral);

struct DihedralSummary {
  double least = 0;        ///< radians
  std::size_t below = 0;   ///< tets with a smaller angle than asked for
  std::size_t forced = 0;  ///< of those
};

/// Looks only at tets whose quality allows so small an angle.
DihedralSummary summarize_dihedrals(WorkingMesh& mesh, double least_wanted);

}  // namespace tetloom::tets
