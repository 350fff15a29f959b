#pragma once
// Volumes filled in parts, for the tests of that.
#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "mesher/volume/volume_mesher.hpp"
#include "tests/mesher/volume_surfaces.hpp"
#include "tetloom/tasks.hpp"

namespace tetloom::volume_tests {

inline constexpr double kOnePart = std::numeric_limits<double>::infinity();

struct PartsCase {
  const char* name;
  Surface surface;
  SizeField sizes;
  double tets_per_part;
  LatticeKind lattice = LatticeKind::Bcc;
};

inline VolumeMesh fill_case(const PartsCase& one, double tets_per_part, const TaskRunner& runner) {
  VolumeOptions options;
  options.tets_per_part = tets_per_part;
  options.lattice = one.lattice;
  return fill_volume(one.surface.input(one.sizes), options, runner);
}

inline VolumeMesh fill_case(const PartsCase& one, int threads = 2) {
  return fill_case(one, one.tets_per_part, TaskRunner(threads));
}

inline bool same_mesh(const VolumeMesh& a, const VolumeMesh& b) {
  return a.new_points == b.new_points && a.tet_to_vert == b.tet_to_vert && a.tet_to_region == b.tet_to_region;
}

struct Qualities {
  double mean = 0, low = 0;  // low: of the worst hundredth
};

inline Qualities qualities_of(const Surface& surface, const VolumeMesh& mesh) {
  const std::vector<Vec3> points = all_points(surface, mesh);
  std::vector<double> all;
  for (const auto& t : mesh.tet_to_vert) {
    double squares = 0;
    for (std::size_t i = 0; i < 4; ++i)
      for (std::size_t j = i + 1; j < 4; ++j) squares += norm2(points[t[i]] - points[t[j]]);
    all.push_back(12 * std::pow(3 * volume_of(points, t), 2.0 / 3) / squares);
  }
  Qualities result;
  for (const double quality : all) result.mean += quality / double(all.size());
  std::sort(all.begin(), all.end());
  result.low = all[all.size() / 100];
  return result;
}

inline Surface round_ball(int levels) {
  return ball_surface(levels, {0, 0, 0}, 0, [](const Vec3&) { return 1.0; });
}

inline Surface scaled(Surface surface, double scale) {
  for (Vec3& x : surface.points) x = scale * x;
  return surface;
}

/// A ball with holes of twisted prisms, turned against the diagonals of their sides: triangles that are long for the
/// size, many of them no faces of any Delaunay tetrahedralisation.
inline Surface ball_with_prisms(int levels, const std::vector<Vec3>& centers, double radius) {
  Surface surface = round_ball(levels);
  for (const Vec3& center : centers) {
    Surface prism;
    for (std::uint32_t k = 0; k < 6; ++k) {
      const double angle = 2.0943951023931953 * (k % 3) + (k < 3 ? 0 : -0.5);
      prism.points.push_back(center + radius * Vec3{std::cos(angle), std::sin(angle), k < 3 ? -2.0 / 3 : 2.0 / 3});
    }
    prism.add({0, 2, 1}, 0, kOutside, 1), prism.add({3, 4, 5}, 0, kOutside, 1);
    for (std::uint32_t k = 0; k < 3; ++k) {
      const std::uint32_t next = (k + 1) % 3;
      prism.add({k, next, 3 + k}, 0, kOutside, 2), prism.add({next, 3 + next, 3 + k}, 0, kOutside, 2);
    }
    surface.append(prism);
  }
  return surface;
}

}  // namespace tetloom::volume_tests
