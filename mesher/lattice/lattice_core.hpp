#pragma once
// The tetrahedra that a lattice has where nothing disturbs it, written with their neighbours in closed form.
//
// A site is *pure* when it and the sites next to it (12 or 14) are there, when the same holds for each of these unless
// there is but one level, and when it is not near the surface. No other point then lies within
// LatticeShape::near_surface() sizes of it: the circumspheres at it are empty (their radius is less than half of that,
// and wherever a foreign point comes as near, it displaces the lattice point next to it). So the tetrahedra at a pure
// site are tetrahedra of the Delaunay tetrahedralisation of all points, and whatever else that has needs no pure site:
// the Delaunay tetrahedralisation of all but the pure ones holds it.
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "core/tets/tet_mesh.hpp"
#include "mesher/lattice/lattice_points.hpp"
#include "tetloom/tasks.hpp"

namespace tetloom::lattice {

/// What a core leaves to the shell, and where it is open.
struct LatticeCore {
  std::vector<std::uint32_t> shell_verts;    ///< vertices of sites that are not pure, ascending
  std::vector<std::uint16_t> pure_around;    ///< per shell vertex: which sites of LatticeShape::around() are pure
  std::vector<tets::FaceCode> open_faces;    ///< faces of core tets with no core tet behind them, ascending
  std::vector<std::uint32_t> level_to_vert;  ///< the first vertex of each level, and one past the last
  std::uint32_t first_own_end = 0;           ///< one past the first level's own vertices
  /// Tets in ranges, ascending: all that have vertices from first_own_end on, and few others.
  std::vector<std::array<std::uint32_t, 2>> beyond_first;
};

/// How far the neighbourhood of a part has to be known, in cubes of a level.
inline constexpr double kReach = 2.1, kGradedReach = 3.1;

/// Appends the points of `levels` to `mesh`, in their order, and then all tetrahedra at pure sites, without fixed
/// faces; `to_region` stays empty, for join_shell to fill. Pre: `mesh` has no tets. Errors: OutOfMemory beyond 2^29
/// tets; Cancelled.
///
/// Where a part knows but the neighbourhood of its own sites, it makes the tets of the lattice's cubes that begin at
/// its own, so that every tet is made by one part; shell vertices are its own, and open faces are all that have no tet
/// of the part behind them. Pre: foreign sites reach kReach cubes (kGradedReach with several levels) beyond it.
LatticeCore emit_core(tets::TetMesh& mesh, std::span<const LevelPoints> levels, const TaskRunner& runner);

}  // namespace tetloom::lattice
