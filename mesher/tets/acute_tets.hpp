#pragma once
// The tets whose smallest dihedral angle is below the one asked for, and what forces it on them.
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "core/base/error.hpp"
#include "core/base/vec.hpp"

namespace tetloom {

enum class AngleCause : std::uint8_t {
  NotForced,        ///< nothing that was looked for
  SurfaceAngle,     ///< the angle lies between two triangles of the surface that meet at less than what was asked for
  SurfaceTriangle,  ///< the tet has a triangle of the surface whose quality is below 1/2
  SurfacePoints,    ///< two of its points are of the surface, and nearer than a third of its longest edge
  NarrowRegion  ///< a point of the surface, of it or of a tet beside it, is that near to a triangle that others have
};

struct AcuteTet {
  double angle = 0;  ///< degrees, the smallest of its dihedral angles
  Vec3 point;        ///< its centre
  AngleCause cause = AngleCause::NotForced;
  /// Degrees: between the two triangles, or the smallest of the one triangle, or that at which `cause_length` is seen
  /// over the tet's longest edge; 0 where nothing forces it.
  double cause_angle = 0;
  double cause_length = 0;  ///< between the two points, or the point and the triangle; else 0; model length
  std::vector<std::array<std::uint32_t, 3>> triangles;  ///< of the surface: two, one or none; by their vertices
  std::vector<std::uint32_t> points;                    ///< the two near each other, the one near the triangle, or none
  /// Where known: the model faces of the triangles and the model edge where they meet, or what the points lie on; the
  /// highest dimension first.
  std::vector<NamedEntity> entities;
};

inline constexpr std::size_t kMostAcuteTets = 100;

/// Sorts by angle, then by place, and drops all but the first kMostAcuteTets.
void keep_worst(std::vector<AcuteTet>& tets);

}  // namespace tetloom

namespace tetloom::tets {

class WorkingMesh;
struct TetMesh;

struct DihedralSummary {
  double least = 0;                                   ///< radians; at most `known_least`
  std::size_t below = 0;                              ///< tets with a smaller angle than asked for
  std::size_t angles = 0, triangles = 0, points = 0;  ///< of those, by cause; the last two causes together
  std::vector<AcuteTet> worst;                        ///< as keep_worst leaves them, without entities

  std::size_t forced() const { return angles + triangles + points; }
};

/// Looks only at tets whose quality allows an angle below `least_wanted` (radians). The causes are tried in their
/// order: where the surface leaves several tets at an edge less than that together, none of them has a choice.
/// `known_least`: an angle of this mesh or of another that is summarised with it; what has none below it and below
/// `least_wanted` is not looked at.
DihedralSummary summarize_dihedrals(WorkingMesh& mesh, double least_wanted, double known_least);

/// One mesh alone.
DihedralSummary summarize_dihedrals(WorkingMesh& mesh, double least_wanted);

/// Radians, of the tet of the least quality: most meshes have few smaller ones. That of a regular tet where all are
/// dead.
double dihedral_of_worst(const TetMesh& mesh, std::span<const float> qualities);

}  // namespace tetloom::tets
