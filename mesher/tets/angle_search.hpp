#pragma once
// Pattern searches (Hooke & Jeeves 1961) for places at which the smallest dihedral angle of the tets at a point is
// larger.
//
// For what the mean ratio does not see. In a wall of one layer it does not depend on where the vertices of one side lie
// beside those of the other, while the angles are largest where they lie beside the middles of triangles. At a needle
// of the surface it prefers vertices far away, where the angle is the needle's; near its middle angles are larger.
#include <functional>
#include <span>

#include "core/tets/vertex_star.hpp"

namespace tetloom::tets {

/// A move has to make the smallest angle larger by this factor.
inline constexpr double kAngleGain = 1.01;
/// No tet of less than this share of the least quality of its star comes of a move.
inline constexpr double kAngleQualityShare = 0.5;

/// The cosine of the smallest dihedral angle of the tets with the star's vertex at `x`; where that is at least
/// `enough`, any cosine that is. The vertex is where it was afterwards.
double largest_cosine(WorkingMesh& mesh, const VertexStar& star, const Vec3& x, double enough = 2);

/// The cosine that has to be beaten by a move of the star's vertex.
double cosine_to_beat(WorkingMesh& mesh, const VertexStar& star);

/// The step along one of `directions`, of length 1, after which the smallest angle is largest, its cosine below `goal`;
/// zero where there is none. Steps are shares of `reach`; those that `is_allowed` refuses are not looked at.
Vec3 find_widest_step(WorkingMesh& mesh, const VertexStar& star, std::span<const Vec3> directions, double reach,
                      double goal, const std::function<bool(const Vec3& step)>& is_allowed);

/// Moves the vertex inside of a region at `corner` of `tet` to such a place; false where it has none, or is of the
/// surface. Tets stay positive in exact arithmetic, and their cubed quality does not fall below `least`.
bool move_for_angle(WorkingMesh& mesh, std::uint32_t tet, std::uint32_t corner, double least);

/// Puts a point into the tets around the edge at which `tet` has its smallest angle, where that makes the smallest
/// angle of these tets larger by a third, and at least 3 degrees; false where it does not, or the edge is of the
/// surface. The new tets are positive in exact arithmetic, and of a cubed quality above `least`.
bool insert_for_angle(WorkingMesh& mesh, std::uint32_t tet, double least);

}  // namespace tetloom::tets
