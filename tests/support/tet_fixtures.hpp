#pragma once
// Small tet meshes with neighbours, for the tests of what changes them.
#include <algorithm>
#include <array>
#include <cstdint>
#include <map>
#include <random>
#include <set>
#include <vector>

#include "core/predicates/predicates.hpp"
#include "core/tets/tet_mesh.hpp"
#include "core/tets/tet_quality.hpp"

namespace tetloom::tet_tests {

using tets::FaceCode;
using tets::kNone;
using tets::TetMesh;

/// The tets by their vertices, whatever the order of corners and tets.
inline std::set<std::array<std::uint32_t, 4>> tets_of(const TetMesh& mesh) {
  std::set<std::array<std::uint32_t, 4>> tets;
  for (std::uint32_t t = 0; t < mesh.size(); ++t) {
    std::array<std::uint32_t, 4> tet;
    for (std::size_t i = 0; i < 4; ++i) tet[i] = mesh.to_vert[std::size_t{t} * 4 + i];
    std::sort(tet.begin(), tet.end());
    tets.insert(tet);
  }
  return tets;
}

/// Orients the tets, links them and fixes every face with nothing or another region behind it.
inline TetMesh make_tets(const std::vector<Vec3>& points, std::vector<std::array<std::uint32_t, 4>> tet_to_vert,
                         const std::vector<std::uint32_t>& regions = {}) {
  TetMesh mesh;
  for (const Vec3& p : points) mesh.points.push_back(p);
  std::map<std::array<std::uint32_t, 3>, FaceCode> open;
  for (std::uint32_t t = 0; t < tet_to_vert.size(); ++t) {
    auto& v = tet_to_vert[t];
    if (orient3d(points[v[0]], points[v[1]], points[v[2]], points[v[3]]) < 0) std::swap(v[2], v[3]);
    for (const std::uint32_t vertex : v) mesh.to_vert.push_back(vertex);
    mesh.to_region.push_back(regions.empty() ? 0 : regions[t]);
    mesh.to_fixed.push_back(0);
    for (const FaceCode face : FaceCode::of(t)) {
      const auto& corners = tets::kFaceVerts[face.side()];
      std::array<std::uint32_t, 3> key{v[corners[0]], v[corners[1]], v[corners[2]]};
      std::sort(key.begin(), key.end());
      mesh.to_neighbor.push_back({});
      if (const auto found = open.find(key); found != open.end()) {
        link_sides(mesh, face, found->second);
        open.erase(found);
      } else {
        open[key] = face;
      }
    }
  }
  for (const FaceCode face : mesh.faces()) {
    const FaceCode behind = mesh.behind(face);
    if (!behind.valid() || mesh.to_region[behind.tet()] != mesh.to_region[face.tet()])
      mesh.to_fixed[face.tet()] |= static_cast<std::uint8_t>(1u << face.side());
  }
  return mesh;
}

/// The octahedron around `center`, which is point 6.
inline TetMesh make_octahedron(const Vec3& center) {
  return make_tets(
      {{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}, center},
      {{6, 0, 2, 4}, {6, 2, 1, 4}, {6, 1, 3, 4}, {6, 3, 0, 4}, {6, 0, 2, 5}, {6, 2, 1, 5}, {6, 1, 3, 5}, {6, 3, 0, 5}});
}

inline void fix_face(TetMesh& mesh, FaceCode face) {
  mesh.to_fixed[face.tet()] |= static_cast<std::uint8_t>(1u << face.side());
  const FaceCode behind = mesh.behind(face);
  if (behind.valid()) mesh.to_fixed[behind.tet()] |= static_cast<std::uint8_t>(1u << behind.side());
}

/// `count` tets around the edge from (0, 0, -height) to (0, 0, height), whose ring is a circle of radius 1. Points: the
/// ring, then the lower and the upper end.
inline TetMesh make_ring(std::uint32_t count, double height) {
  std::vector<Vec3> points;
  std::vector<std::array<std::uint32_t, 4>> tets;
  for (std::uint32_t i = 0; i < count; ++i) {
    const double angle = 2 * 3.14159265358979 * i / count;
    points.push_back({std::cos(angle), std::sin(angle), 0.01 * (i % 2)});
    tets.push_back({count, count + 1, i, (i + 1) % count});
  }
  points.push_back({0, 0, -height});
  points.push_back({0, 0, height});
  return make_tets(points, tets);
}

/// n x n x n cubes of six tets each; points inside are shaken, those of the surface come first. Left of x = n / 2 is
/// region 0, right of it region 1 when `regions` is 2; points between the regions count as surface.
struct ShakenGrid {
  TetMesh mesh;
  std::uint32_t fixed_points = 0;
};

inline ShakenGrid make_shaken_grid(int n, int regions, double shake, unsigned seed) {
  std::mt19937 random(seed);
  const auto amount = [&] { return shake * (static_cast<double>(random()) / 4294967296.0 - 0.5); };
  const auto on_surface = [&](int i, int j, int k) {
    return i == 0 || j == 0 || k == 0 || i == n || j == n || k == n || (regions == 2 && i == n / 2);
  };
  std::map<std::array<int, 3>, std::uint32_t> ids;
  std::vector<Vec3> points;
  ShakenGrid grid;
  for (const bool surface : {true, false}) {
    for (int i = 0; i <= n; ++i)
      for (int j = 0; j <= n; ++j)
        for (int k = 0; k <= n; ++k) {
          if (on_surface(i, j, k) != surface) continue;
          ids[{i, j, k}] = static_cast<std::uint32_t>(points.size());
          points.push_back({double(i), double(j), double(k)});
          if (!surface) points.back() += Vec3{amount(), amount(), amount()};
        }
    if (surface) grid.fixed_points = static_cast<std::uint32_t>(points.size());
  }
  std::vector<std::array<std::uint32_t, 4>> tets;
  std::vector<std::uint32_t> tet_regions;
  std::array<int, 3> axes{0, 1, 2};
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < n; ++j)
      for (int k = 0; k < n; ++k) {
        do {
          std::array<int, 3> at{i, j, k};
          std::array<std::uint32_t, 4> tet{ids[at]};
          for (std::size_t s = 0; s < 3; ++s) ++at[static_cast<std::size_t>(axes[s])], tet[s + 1] = ids[at];
          tets.push_back(tet);
          tet_regions.push_back(regions == 2 && i >= n / 2);
        } while (std::next_permutation(axes.begin(), axes.end()));
      }
  grid.mesh = make_tets(points, tets, tet_regions);
  return grid;
}

inline double quality_of(const TetMesh& mesh, std::uint32_t tet) {
  return std::cbrt(
      tets::cubed_quality(mesh.point_of(tet, 0), mesh.point_of(tet, 1), mesh.point_of(tet, 2), mesh.point_of(tet, 3)));
}

inline double least_quality(const TetMesh& mesh) {
  double least = 1;
  for (std::uint32_t t = 0; t < mesh.size(); ++t) {
    if (!mesh.is_dead(t)) least = std::min(least, quality_of(mesh, t));
  }
  return least;
}

inline double volume_of_region(const TetMesh& mesh, std::uint32_t region) {
  double volume = 0;
  for (std::uint32_t t = 0; t < mesh.size(); ++t) {
    if (mesh.is_dead(t) || mesh.to_region[t] != region) continue;
    const Vec3& a = mesh.point_of(t, 0);
    volume += dot(cross(mesh.point_of(t, 1) - a, mesh.point_of(t, 2) - a), mesh.point_of(t, 3) - a) / 6;
  }
  return volume;
}

/// The fixed faces by their vertices, each as often as a tet has it.
inline std::vector<std::array<std::uint32_t, 3>> fixed_faces(const TetMesh& mesh) {
  std::vector<std::array<std::uint32_t, 3>> faces;
  for (const FaceCode face : mesh.faces()) {
    if (mesh.is_dead(face.tet()) || !mesh.is_fixed(face)) continue;
    const auto& corners = tets::kFaceVerts[face.side()];
    std::array<std::uint32_t, 3> key;
    for (std::size_t k = 0; k < 3; ++k) key[k] = mesh.to_vert[face.tet() * 4 + corners[k]];
    std::sort(key.begin(), key.end());
    faces.push_back(key);
  }
  std::sort(faces.begin(), faces.end());
  return faces;
}

inline bool same(const TetMesh& a, const TetMesh& b) {
  return a.points == b.points && a.to_vert == b.to_vert && a.to_neighbor == b.to_neighbor &&
         a.to_region == b.to_region && a.to_fixed == b.to_fixed;
}

}  // namespace tetloom::tet_tests
