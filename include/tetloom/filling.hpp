#pragma once
// What the tetrahedra of a volume are to reach, and how it came to be filled.
#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "tetloom/error.hpp"
#include "tetloom/vec.hpp"

// Which lattice fills the inside of a volume.

namespace tetloom {

/// Bcc: body-centred cubic. A15: of fewer and better tetrahedra for the same mean edge.
enum class LatticeKind { Bcc, A15 };

/// Tets that miss a goal get other points, and another surface where that may change, until no more of that helps or
/// the rounds are over. A goal is no promise: what stays below it is reported, with the reason.
struct QualityGoals {
  double dihedral = 15;     ///< degrees, 0 to 60: the smallest dihedral angle
  double mean_ratio = 0.5;  ///< 0 to .9
  int rounds = 2;  ///< 0 to 100: at most so many inside, and four times as many with the surface or above layers
};

/// Why a tet has a small dihedral angle.
enum class AngleCause : std::uint8_t {
  NotForced,        ///< nothing that was looked for
  SurfaceAngle,     ///< the angle lies between two triangles of the surface that meet at less than what was asked for
  SurfaceTriangle,  ///< the tet has a triangle of the surface whose quality is below 1/2
  SurfacePoints,    ///< two of its points are of the surface, and nearer than a third of its longest edge
  NarrowRegion  ///< a point of the surface, of it or of a tet beside it, is that near to a triangle that others have
};

/// A tet with a small dihedral angle, and why.
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

}  // namespace tetloom

namespace tetloom::tets {

/// What the optimiser of a volume has done, and what it left.
struct OptimizeReport {
  std::size_t edges_removed = 0;
  std::size_t vertices_moved = 0;  ///< moves, not vertices
  std::size_t points_inserted = 0;
  std::size_t vertices_removed = 0;
  std::size_t edges_swapped = 0;             ///< of the surface, where it may change: see surface_improvement.hpp
  std::size_t vertices_slid = 0;             ///< on the surface; moves, not vertices
  double least_before = 0, mean_before = 0;  ///< mean ratio
  double least = 0, mean = 0;                ///< mean ratio
  std::size_t below_goal = 0;                ///< tets of a smaller mean ratio than asked for
  double least_dihedral = 0;                 ///< degrees
  std::size_t below_dihedral = 0;            ///< tets with a smaller angle than asked for
  std::size_t forced = 0;                    ///< of those, tets to which the surface leaves little choice, and why:
  std::size_t forced_by_angles = 0, forced_by_triangles = 0, forced_by_points = 0;
  std::vector<AcuteTet> acute_tets;  ///< the worst of those tets, the worst first
  std::size_t tets = 0;              ///< that were looked at

  /// Takes another mesh into account: sums of counts, means over all tets, the lower of the extremes, the worst tets.
  void add(const OptimizeReport& other);
};

}  // namespace tetloom::tets

namespace tetloom {

/// How complexes came to be filled in parts.
struct FillingPartsFigures {
  /// What one round of bettering tets between parts took.
  struct Strips {
    std::size_t waiting = 0;  ///< vertices between parts at which tets are poor, each counted by every part that has it
    std::size_t tets = 0;     ///< that came into strips
    std::size_t moved = 0;    ///< of those, tets that came from another part
  };
  std::size_t parts = 0;          ///< in complexes of several; 0: there are none
  std::size_t asked = 0;          ///< tets that were certified by what other parts answered
  std::size_t asking_rounds = 0;  ///< the most that a complex took
  std::array<Strips, 3> strips{};
  std::size_t given_up = 0;  ///< complexes that were filled in one part because their parts did not fit together
  std::string given_up_why;  ///< the first one's reason

  void add(const FillingPartsFigures& other);
};

/// How a volume came to be filled. Seconds are of wall time; those of complexes filled at once add up.
struct FillingFigures {
  std::size_t core_tets = 0;          ///< exact lattice tets, as emitted
  std::size_t shell_tets = 0;         ///< between the core and the surface, before optimisation
  std::size_t worker_complexes = 0;   ///< filled by TetGen, as the last resort
  std::size_t missing_triangles = 0;  ///< that were no faces of the Delaunay tetrahedralisation
  std::size_t recovery_points = 0;    ///< put inside to recover them
  FillingPartsFigures parts;
  tets::OptimizeReport optimizer;
  struct Seconds {
    double points = 0, core = 0, delaunay = 0, recovery = 0, join = 0, optimize = 0, surface = 0;
  } seconds;

  void add(const FillingFigures& other);
};

}  // namespace tetloom
