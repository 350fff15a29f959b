#pragma once
// Boundary recovery: the triangles of a given surface as faces of a tetrahedral mesh that holds their points.
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "core/tets/triangle_verts.hpp"
#include "tetloom/tasks.hpp"

namespace tetloom::tets {

/// How much is searched for a missing triangle.
struct RecoverOptions {
  std::uint32_t cavity_points = 40;           ///< of a small polyhedron, at most
  std::uint64_t search_steps = 400'000;       ///< intersection tests in one search for its tetrahedra
  std::uint64_t steps_in_all = 200'000'000;   ///< of all searches without new points, and again of those with them
  std::uint64_t steps_of_group = 20'000'000;  ///< of those with new points in triangles that hang together
  std::uint32_t growths = 8;                  ///< of a cavity that has no tetrahedra with what is wanted
  bool allow_new_points = true;               ///< inside; never on the surface
  /// Asked once, when the searches have taken a while: whether the surface crosses itself, so that more of them are in
  /// vain. May be empty.
  std::function<bool()> is_in_vain = {};
};

/// Options whose searches take no more time than making some 100,000 tets and, for each of the mesh's, a few times what
/// making it takes: 50 steps. A further attempt gets a quarter of that.
inline RecoverOptions recover_options(std::uint64_t tets, int attempt) {
  constexpr std::uint64_t kOfAny = 50'000'000, kPerTet = 50;
  RecoverOptions options;
  options.steps_in_all = std::min(options.steps_in_all, kOfAny + kPerTet * std::min(tets, options.steps_in_all));
  if (attempt > 0) options.steps_in_all /= 4;
  return options;
}

/// Why a triangle is not a face of the mesh.
enum class RecoveryFault : std::uint8_t {
  Degenerate,    ///< a vertex twice, an unknown vertex or three vertices on a line
  Duplicate,     ///< the same three vertices as an earlier triangle
  PointInside,   ///< a point of the mesh lies on it
  Crossed,       ///< a fixed face or an edge of the surface crosses it
  NotRecovered,  ///< the search ended
};

/// A triangle that is no face, and why.
struct UnrecoveredTriangle {
  std::uint32_t triangle;
  RecoveryFault fault;
  Vec3 point;                   ///< on or near the triangle, at the trouble
  std::uint32_t other = kNone;  ///< the triangle that it crosses or repeats, where it is known
};

/// What the recovery has done and left.
struct RecoveryReport {
  std::size_t missing_triangles = 0;             ///< before
  std::size_t missing_edges = 0;                 ///< of these triangles, before
  std::size_t flips = 0;                         ///< reconnections of five points
  std::size_t reconnections = 0;                 ///< of more
  std::size_t new_points = 0;                    ///< that remain
  std::vector<UnrecoveredTriangle> unrecovered;  ///< ascending by triangle
};

/// Makes every triangle a face of `mesh` and fixes it on both sides. Faces that were fixed stay.
///
/// Pre: `mesh` is free of faults (find_fault), its domain is convex, and the surface touches neither its hull nor its
/// outer points. The triangles should meet in common vertices and edges only; where they do not, they are reported and
/// the mesh stays free of faults. New points lie off the surface, behind the given points, whose ids and places stay.
/// Tets may be renumbered; new ones get the region of one that they replace. The result depends on ids only, not on
/// threads. Always ends. Linear where nothing is missing: one pass over the tets. Errors: Cancelled (the mesh is sound
/// then, too), OutOfMemory.
///
/// Missing edges come first, then triangles; each by a search over the tetrahedra of the small polyhedron that it
/// crosses, which grows where the search fails, then with new points (see SteinerRecovery).
RecoveryReport recover_boundary(TetMesh& mesh, std::span<const TriangleVerts> triangles, const RecoverOptions& options,
                                const TaskRunner& runner);

}  // namespace tetloom::tets
