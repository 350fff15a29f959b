#pragma once
// What two tetrahedra have in common.
#include <array>
#include <cstdint>
#include <span>

#include "tetloom/metric.hpp"

namespace tetloom::adapt {

/// The four corners of a tet, in its order.
using Corners = std::array<Vec3, 4>;

inline Corners corners_of(std::span<const Vec3> points, const TetVerts& v) {
  return {points[v[0]], points[v[1]], points[v[2]], points[v[3]]};
}
inline Corners corners_of(const TetView& mesh, std::uint32_t tet) { return corners_of(mesh.points, mesh.tets[tet]); }

inline double volume_of(const Corners& x) { return dot(cross(x[1] - x[0], x[2] - x[0]), x[3] - x[0]) / 6; }

inline Vec3 center_of(const Corners& x) { return 0.25 * ((x[0] + x[1]) + (x[2] + x[3])); }

/// Where the corners of a tet lie: six times the volumes that they make with the four faces of another one, positive
/// inside of it. Indexed [face][corner].
using FaceValues = std::array<std::array<double, 4>, 4>;

/// The values of face `face` of the tet `verts` of `points` at the corners `x`. Both tets of a face get the same
/// numbers with opposite signs, so that what one of them loses to round-off the other gets. What is below the round-off
/// of its own computation is 0.
std::array<double, 4> face_values(std::span<const Vec3> points, const TetVerts& verts, std::size_t face,
                                  const Corners& x);

/// The part of a tet that lies in another one. Lengths and places are barycentric in the first, so they lose no digits
/// where tets are thin.
struct ClippedTet {
  double share = 0;  ///< of its volume
  std::array<double, 4>
      moment{};  ///< the integrals of its barycentric coordinates, over its volume; their sum is `share`
  std::array<bool, 4> crossed{};  ///< per face of the other one: whether the tet goes on behind it, next to that part
};

/// Clips a tet at the four planes of another one, one after the other; the polyhedron is kept as the graph of its
/// vertices, three edges at each (as Powell & Abel 2015 do), so that it stays closed whatever the round-off.
ClippedTet clip_tet(const FaceValues& values);

}  // namespace tetloom::adapt
