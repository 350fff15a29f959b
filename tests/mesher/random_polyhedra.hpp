#pragma once
// Closed surfaces at random, from harmless to wicked; some cross themselves, which is for the caller to find out.
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <numeric>
#include <random>
#include <string>
#include <vector>

#include "core/tets/triangle_verts.hpp"
#include "mesher/tets/delaunay.hpp"
#include "tests/mesher/volume_surfaces.hpp"
#include "tetloom/tasks.hpp"

namespace tetloom::volume_tests {

class RandomPolyhedra {
 public:
  explicit RandomPolyhedra(std::uint64_t seed) : random_(seed) {}

  struct Made {
    std::string kind;
    Surface surface;
    double size = 1;  ///< to fill it with
  };
  static constexpr int kKinds = 10, kNeedles = 6;

  Made make(int kind) {
    switch (kind) {
      case 0: return {"tets of random points", delaunay_tets(1), 0.4};
      case 1: return {"regions of tets of random points", delaunay_tets(4), 0.3};
      case 2: return {"shaken cubes", shaken_cubes(2), 0.7};
      case 3: return {"regions of shaken cubes", shaken_cubes(4), 0.7};
      case 4: return {"star", star(), 0.4};
      case 5: return {"twisted prism", twisted_prism(), uniform(0.15, 0.8)};
      case 6: return {"needles and flat triangles", needles(), 0.4};
      case 7: return {"thin plate", thin_plate(), uniform(0.1, 1)};
      case 8: return {"wedge", wedge(), 0.3};
      default: return {"sizes of 1 : 10000", graded(), 0.5};
    }
  }

 private:
  double uniform(double low, double high) { return std::uniform_real_distribution<double>(low, high)(random_); }
  std::uint32_t below(std::uint32_t count) { return static_cast<std::uint32_t>(random_() % count); }
  Vec3 in_cube() { return {uniform(0, 1), uniform(0, 1), uniform(0, 1)}; }

  /// Tets of a Delaunay tetrahedralisation taken at random, or those around some of its points: edges and vertices
  /// where any number of pieces meet.
  Surface delaunay_tets(std::uint32_t regions) {
    Surface surface;
    for (std::uint32_t i = 10 + below(60); i-- > 0;) surface.points.push_back(in_cube());
    tets::TetMesh mesh;
    mesh.points = GrowingArray<Vec3>(std::span(surface.points));
    std::vector<std::uint32_t> ids(surface.points.size());
    std::iota(ids.begin(), ids.end(), 0u);
    make_delaunay(mesh, ids, TaskRunner(1));
    shake(mesh, surface.points.size());
    std::copy_n(mesh.points.begin(), surface.points.size(), surface.points.begin());
    const double share = uniform(0.2, 0.9);
    std::vector<std::uint32_t> to_region(mesh.size(), kOutside);
    for (std::uint32_t t = 0; t < mesh.size(); ++t) {
      const std::uint32_t* v = mesh.to_vert.data() + std::size_t{t} * 4;
      const bool is_inner = std::all_of(v, v + 4, [&](std::uint32_t x) { return x < surface.points.size(); });
      if (is_inner && uniform(0, 1) < share) to_region[t] = below(regions);
    }
    for (const tets::FaceCode face : mesh.faces()) {
      const tets::FaceCode behind = mesh.behind(face);
      if (!behind.valid() || behind < face || to_region[face.tet()] == to_region[behind.tet()]) continue;
      surface.add(tets::verts_of(mesh, face), to_region[behind.tet()], to_region[face.tet()], 0);
    }
    return surface;
  }

  /// Moves points as far as all tets stay positive: then what they bound crosses itself nowhere, but is far from
  /// Delaunay.
  void shake(tets::TetMesh& mesh, std::size_t count) {
    std::vector<std::vector<std::uint32_t>> point_to_tets(mesh.points.size());
    for (std::size_t i = 0; i < mesh.to_vert.size(); ++i)
      point_to_tets[mesh.to_vert[i]].push_back(static_cast<std::uint32_t>(i / 4));
    const auto is_positive = [&](std::uint32_t t) {
      return orient3d(mesh.point_of(t, 0), mesh.point_of(t, 1), mesh.point_of(t, 2), mesh.point_of(t, 3)) > 0;
    };
    for (int round = 0; round < 6; ++round) {
      for (std::size_t v = 0; v < count; ++v) {
        const Vec3 before = mesh.points[v];
        mesh.points[v] += 0.15 * (2 * in_cube() - Vec3{1, 1, 1});
        if (!std::ranges::all_of(point_to_tets[v], is_positive)) mesh.points[v] = before;
      }
    }
  }

  Surface shaken_cubes(std::uint32_t values) {
    const int n = 2 + static_cast<int>(below(3));
    std::vector<std::uint32_t> full(static_cast<std::size_t>(n * n * n));
    for (std::uint32_t& region : full) region = below(values) - 1;  // 0 - 1 is kOutside
    Surface surface = voxel_surface(
        {n, n, n}, 1, [&](int i, int j, int k) { return full[static_cast<std::size_t>((i * n + j) * n + k)]; });
    const double amount = uniform(0, 0.35);
    for (Vec3& p : surface.points) p += amount * (2 * in_cube() - Vec3{1, 1, 1});
    return surface;
  }

  Surface star() {
    const double low = std::pow(10.0, uniform(-2, 0));
    return ball_surface(1 + static_cast<int>(below(3)), {0, 0, 0}, 0, [&](const Vec3&) { return uniform(low, 1); });
  }

  Surface twisted_prism() {
    Surface surface;
    const std::uint32_t n = 3 + below(10);
    const double turn = uniform(-1.5, 1.5) * std::numbers::pi / n, height = uniform(0.2, 3);
    for (std::uint32_t k = 0; k < 2 * n; ++k) {
      const double angle = 2 * std::numbers::pi * (k % n) / n + (k < n ? 0 : turn);
      surface.points.push_back({std::cos(angle), std::sin(angle), k < n ? 0 : height});
    }
    for (std::uint32_t k = 0; k < n; ++k) {
      const std::uint32_t next = (k + 1) % n;
      surface.add({k, next, n + k}, kOutside, 0, 0), surface.add({next, n + next, n + k}, kOutside, 0, 0);
      if (k >= 2) surface.add({0, k, k - 1}, kOutside, 0, 1), surface.add({n, n + k - 1, n + k}, kOutside, 0, 2);
    }
    return surface;
  }

  /// A ball whose triangles are divided at points near their edges and corners.
  Surface needles() {
    Surface surface = ball_surface(1, {0, 0, 0}, 0, [&](const Vec3&) { return uniform(0.7, 1); });
    for (int i = 0; i < 40; ++i) {
      const std::uint32_t t = below(static_cast<std::uint32_t>(surface.tri_to_vert.size()));
      const auto [a, b, c] = surface.tri_to_vert[t];
      const double near_edge = std::pow(10.0, uniform(-6, -0.5)), along = std::pow(10.0, uniform(-4, -0.3));
      const Vec3 on_edge = (1 - along) * surface.points[a] + along * surface.points[b];
      const auto fresh = static_cast<std::uint32_t>(surface.points.size());
      surface.points.push_back((1 - near_edge) * on_edge + near_edge * surface.points[c]);
      surface.tri_to_vert[t] = {a, b, fresh};
      surface.add({b, c, fresh}, kOutside, 0, 0), surface.add({c, a, fresh}, kOutside, 0, 0);
    }
    return surface;
  }

  /// n x m squares on both sides, with other diagonals above than below, a thousandth of its width thick.
  Surface thin_plate() {
    const int n = 1 + static_cast<int>(below(6)), m = 1 + static_cast<int>(below(6));
    Surface surface = voxel_surface({n, m, 1}, 1, [](int, int, int) { return 0u; });
    for (std::size_t t = 0; t + 1 < surface.tri_to_vert.size(); t += 2) {
      if (below(2) != 0) continue;
      const auto [a, b, c] = surface.tri_to_vert[t];
      const std::uint32_t d = surface.tri_to_vert[t + 1][2];
      surface.tri_to_vert[t] = {a, b, d}, surface.tri_to_vert[t + 1] = {b, c, d};
    }
    const double shift = below(2) == 0 ? 0 : 0.3;
    for (Vec3& p : surface.points) {
      p += shift * Vec3{uniform(-1, 1), uniform(-1, 1), 0};
      p.z *= 1e-3 * n;
    }
    return surface;
  }

  /// Two sides that meet at an edge under a degree or so.
  Surface wedge() {
    const int n = 1 + static_cast<int>(below(5));
    Surface surface = voxel_surface({n, 1, 1}, 1, [](int, int, int) { return 0u; });
    const double slope = std::tan(uniform(0.2, 2) * std::numbers::pi / 180);
    for (Vec3& p : surface.points) {
      const double depth = p.y == 0 ? 1e-4 : 1;  // a narrow end in place of none keeps the squares squares
      p = {p.x + uniform(-0.2, 0.2), p.y, p.z * slope * depth};
    }
    return surface;
  }

  /// A ball whose triangles at one corner are halved again and again.
  Surface graded() {
    Surface surface = ball_surface(1, {0, 0, 0}, 0, [&](const Vec3&) { return uniform(0.8, 1); });
    const std::uint32_t corner = below(6);
    for (int level = 0; level < 14; ++level) halve_at(surface, corner);
    return surface;
  }

  static void halve_at(Surface& surface, std::uint32_t corner) {
    std::map<std::uint32_t, std::uint32_t> end_to_middle;
    const auto middle = [&](std::uint32_t end) {
      const auto [entry, is_new] = end_to_middle.emplace(end, static_cast<std::uint32_t>(surface.points.size()));
      if (is_new) surface.points.push_back(0.5 * (surface.points[corner] + surface.points[end]));
      return entry->second;
    };
    for (std::size_t t = 0, count = surface.tri_to_vert.size(); t < count; ++t) {
      auto v = surface.tri_to_vert[t];
      const auto at = std::find(v.begin(), v.end(), corner);
      if (at == v.end()) continue;
      std::rotate(v.begin(), at, v.end());
      const std::uint32_t b = middle(v[1]), c = middle(v[2]);
      surface.tri_to_vert[t] = {corner, b, c};
      surface.add({b, v[1], v[2]}, kOutside, 0, 0), surface.add({b, v[2], c}, kOutside, 0, 0);
    }
  }

  std::mt19937_64 random_;
};

/// Six times the volume of each region, from its surface.
inline std::map<std::uint32_t, double> enclosed_volumes(const Surface& surface) {
  std::map<std::uint32_t, double> volumes;
  const Vec3 origin = surface.points.empty() ? Vec3{} : surface.points[0];
  for (std::size_t t = 0; t < surface.tri_to_vert.size(); ++t) {
    const auto& [a, b, c] = surface.tri_to_vert[t];
    const double cone =
        dot(surface.points[a] - origin, cross(surface.points[b] - origin, surface.points[c] - origin)) / 6;
    const FaceSides& sides = surface.tri_to_sides[t];
    if (sides.back.valid()) volumes[sides.back.value] += cone;
    if (sides.front.valid()) volumes[sides.front.value] -= cone;
  }
  return volumes;
}

}  // namespace tetloom::volume_tests
