#pragma once
// Search for the tetrahedra of a small polyhedron.
#include <array>
#include <cstdint>
#include <vector>

#include "tetloom/vec.hpp"

namespace tetloom::tets {

/// A polyhedron bounded by triangles, which may touch itself and may have constraints inside: a triangle that must be
/// there is listed with both orientations, an edge in `edges`.
struct SmallPolyhedron {
  std::vector<Vec3> points;                        ///< 64 at most
  std::vector<std::array<std::uint8_t, 3>> faces;  ///< counter-clockwise as seen from inside
  std::vector<std::array<std::uint8_t, 2>> edges;  ///< not on faces
};

/// The tets of a small polyhedron, if it has any.
struct SmallFilling {
  enum Outcome : std::uint8_t { Found, Impossible, GivenUp } outcome = Impossible;
  std::vector<std::array<std::uint8_t, 4>> tets;  ///< of positive volume
  std::vector<std::uint32_t> face_to_dead_ends;   ///< how often nothing fitted on a face
  std::uint64_t steps = 0;
};

/// Tetrahedra between the given points that fill `polyhedron`, conform to its faces and edges and use all points.
/// `max_steps` bounds the intersection tests, roughly. Depends on the input only.
///
/// Exact: tets of positive volume whose boundary as a chain is that of the polyhedron cover it once. Intersection
/// tests only prune. Backtracking over the face on which the fewest tets fit, as in J. Liu, B. Chen, Y. Chen, "Boundary
/// recovery after 3D Delaunay tetrahedralization without adding extra nodes" (2007); among these the tets with the
/// smallest empty spheres come first, so that a constrained Delaunay tetrahedralisation is found without backtracking,
/// as by gift wrapping. Departs from the paper: fronts that had no filling are remembered; edges can be demanded.
SmallFilling fill_small_polyhedron(const SmallPolyhedron& polyhedron, std::uint64_t max_steps);

}  // namespace tetloom::tets
