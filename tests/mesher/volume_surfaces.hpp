#pragma once
// Surfaces for the tests of the volume mesher, and an independent judge of what came out.
#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstdint>
#include <functional>
#include <map>
#include <random>
#include <set>
#include <vector>

#include "core/predicates/predicates.hpp"
#include "mesher/volume/gather_volume.hpp"
#include "mesher/volume/volume_mesher.hpp"

namespace tetloom::volume_tests {

inline constexpr std::uint32_t kOutside = 0xffffffffu;

struct Surface {
  std::vector<Vec3> points;
  std::vector<std::array<std::uint32_t, 3>> tri_to_vert;
  std::vector<FaceSides> tri_to_sides;
  std::vector<std::uint32_t> tri_to_face;

  void add(std::array<std::uint32_t, 3> triangle, std::uint32_t front, std::uint32_t back, std::uint32_t face) {
    const auto id = [](std::uint32_t r) { return r == kOutside ? ModelRegionId{} : ModelRegionId{r}; };
    tri_to_vert.push_back(triangle);
    tri_to_sides.push_back({id(front), id(back)});
    tri_to_face.push_back(face);
  }
  void append(const Surface& other) {
    const auto offset = static_cast<std::uint32_t>(points.size());
    points.insert(points.end(), other.points.begin(), other.points.end());
    for (auto t : other.tri_to_vert) tri_to_vert.push_back({t[0] + offset, t[1] + offset, t[2] + offset});
    tri_to_sides.insert(tri_to_sides.end(), other.tri_to_sides.begin(), other.tri_to_sides.end());
    tri_to_face.insert(tri_to_face.end(), other.tri_to_face.begin(), other.tri_to_face.end());
  }
  VolumeInput input(const SizeField& sizes) const {
    return {points, tri_to_vert, tri_to_sides, tri_to_face, nullptr, &sizes};
  }
};

/// The boundary of unit cubes: `region_at(i, j, k)` names the region of a cube, kOutside for none. Every square between
/// two different regions is cut into n x n x 2 triangles; its model face is its direction.
inline Surface voxel_surface(std::array<int, 3> count, int n,
                             const std::function<std::uint32_t(int, int, int)>& region_at) {
  Surface surface;
  std::map<std::array<int, 3>, std::uint32_t> corner_to_id;
  const auto point = [&](std::array<int, 3> at) {
    const auto [entry, is_new] = corner_to_id.emplace(at, static_cast<std::uint32_t>(surface.points.size()));
    if (is_new) surface.points.push_back({double(at[0]) / n, double(at[1]) / n, double(at[2]) / n});
    return entry->second;
  };
  const auto region = [&](std::array<int, 3> c) {
    for (int axis = 0; axis < 3; ++axis) {
      if (c[axis] < 0 || c[axis] >= count[axis]) return kOutside;
    }
    return region_at(c[0], c[1], c[2]);
  };
  for (int axis = 0; axis < 3; ++axis) {
    const int u = (axis + 1) % 3, v = (axis + 2) % 3;
    std::array<int, 3> c{};
    for (c[0] = 0; c[0] <= count[0]; ++c[0]) {
      for (c[1] = 0; c[1] <= count[1]; ++c[1]) {
        for (c[2] = 0; c[2] <= count[2]; ++c[2]) {
          std::array<int, 3> below = c;
          --below[axis];
          const std::uint32_t front = region(c), back = region(below);  // the normal points along the axis
          if (front == back) continue;
          for (int i = 0; i < n; ++i) {
            for (int j = 0; j < n; ++j) {
              const auto corner = [&](int du, int dv) {
                std::array<int, 3> at{c[0] * n, c[1] * n, c[2] * n};
                at[u] += i + du, at[v] += j + dv;
                return point(at);
              };
              const std::uint32_t p00 = corner(0, 0), p10 = corner(1, 0), p01 = corner(0, 1), p11 = corner(1, 1);
              surface.add({p00, p10, p11}, front, back, static_cast<std::uint32_t>(axis));
              surface.add({p00, p11, p01}, front, back, static_cast<std::uint32_t>(axis));
            }
          }
        }
      }
    }
  }
  return surface;
}

inline Surface cube_surface(int n) {
  return voxel_surface({1, 1, 1}, n, [](int, int, int) { return 0u; });
}

/// A sphere from an octahedron cut `levels` times, around `center`; region `region` inside. `radius_at` gives the
/// radius for each unit direction.
template <class Radius>
Surface ball_surface(int levels, const Vec3& center, std::uint32_t region, Radius&& radius_at) {
  Surface surface;
  surface.points = {{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}};
  std::vector<std::array<std::uint32_t, 3>> triangles{{0, 2, 4}, {2, 1, 4}, {1, 3, 4}, {3, 0, 4},
                                                      {2, 0, 5}, {1, 2, 5}, {3, 1, 5}, {0, 3, 5}};
  for (int level = 0; level < levels; ++level) {
    std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> edge_to_middle;
    const auto middle = [&](std::uint32_t a, std::uint32_t b) {
      const auto [entry, is_new] =
          edge_to_middle.emplace(std::minmax(a, b), static_cast<std::uint32_t>(surface.points.size()));
      if (is_new) surface.points.push_back(normalized(surface.points[a] + surface.points[b]));
      return entry->second;
    };
    std::vector<std::array<std::uint32_t, 3>> finer;
    for (const auto& [a, b, c] : triangles) {
      const std::uint32_t ab = middle(a, b), bc = middle(b, c), ca = middle(c, a);
      finer.insert(finer.end(), {{a, ab, ca}, {ab, b, bc}, {ca, bc, c}, {ab, bc, ca}});
    }
    triangles = std::move(finer);
  }
  for (const auto& triangle : triangles) surface.add(triangle, kOutside, region, 0);
  for (Vec3& p : surface.points) p = center + radius_at(p) * p;
  return surface;
}

/// The unit ball of region 0.
inline Surface ball(int levels = 2) {
  return ball_surface(levels, {0, 0, 0}, 0, [](const Vec3&) { return 1.0; });
}

/// Sizes that grow from `low` to `high` along x in [-1.5, 1.5].
inline SizeField growing_sizes(double low, double high) {
  SizeOctree tree;
  tree.origin = {-1.5, -1.5, -1.5};
  tree.width = 3;
  tree.domain = {tree.origin, {1.5, 1.5, 1.5}};
  tree.size = high;
  tree.gradation = (high - low) / 3;
  std::vector<std::array<float, 8>> leaf_to_ratios;
  for (std::uint32_t octant = 0; octant < 8; ++octant) {
    tree.cells.push_back(SizeOctree::kLeafBit + octant);
    std::array<float, 8> ratios;
    for (std::uint32_t corner = 0; corner < 8; ++corner) {
      const double x = 0.5 * ((octant & 1) + (corner & 1));
      ratios[corner] = static_cast<float>((low + x * (high - low)) / high);
    }
    leaf_to_ratios.push_back(ratios);
  }
  set_corner_ratios(tree, leaf_to_ratios);
  return SizeField::from_octree(tree);
}

struct MovedPoint {
  std::uint32_t point = 0;  ///< of the surface
  Vec3 to;
};

struct ChangedTriangle {
  std::uint32_t triangle = 0;  ///< of the surface
  std::array<std::uint32_t, 3> verts{};
};

/// A filled volume in one piece. Vertices below the number of the surface's points are these, the others index
/// `new_points` after subtracting that.
struct VolumeMesh {
  std::vector<Vec3> new_points;
  std::vector<std::array<std::uint32_t, 4>> tet_to_vert;
  std::vector<std::uint32_t> tet_to_region;
  std::vector<MovedPoint> moved_points;            ///< ascending
  std::vector<ChangedTriangle> changed_triangles;  ///< ascending
  std::vector<Diagnostic> errors, warnings;
  FillingFigures figures;
};

/// The volume filled by this process and put together, with what has become of the surface.
inline VolumeMesh fill_volume(const VolumeInput& input, const VolumeOptions& options, const TaskRunner& runner) {
  const auto communicator = make_thread_communicator();
  VolumeParts parts = tetloom::fill_volume(input, options, runner);
  VolumeMesh result;
  result.errors = std::move(parts.errors), result.warnings = std::move(parts.warnings);
  result.figures = std::move(parts.figures);
  Mesh mesh;
  mesh.points.assign(input.points.begin(), input.points.end());
  mesh.tri_to_vert.assign(input.tri_to_vert.begin(), input.tri_to_vert.end());
  gather_volume(std::move(parts), mesh, *communicator, runner);
  for (std::uint32_t v = 0; v < input.points.size(); ++v)
    if (mesh.points[v] != input.points[v]) result.moved_points.push_back({v, mesh.points[v]});
  for (std::uint32_t t = 0; t < input.tri_to_vert.size(); ++t)
    if (mesh.tri_to_vert[t] != input.tri_to_vert[t]) result.changed_triangles.push_back({t, mesh.tri_to_vert[t]});
  result.new_points.assign(mesh.points.begin() + static_cast<std::ptrdiff_t>(input.points.size()), mesh.points.end());
  result.tet_to_vert = std::move(mesh.tet_to_vert), result.tet_to_region = std::move(mesh.tet_to_entity);
  return result;
}

inline std::vector<Vec3> all_points(const Surface& surface, const VolumeMesh& mesh) {
  std::vector<Vec3> points = surface.points;
  points.insert(points.end(), mesh.new_points.begin(), mesh.new_points.end());
  return points;
}

inline double volume_of(const std::vector<Vec3>& p, const std::array<std::uint32_t, 4>& t) {
  return dot(cross(p[t[1]] - p[t[0]], p[t[2]] - p[t[0]]), p[t[3]] - p[t[0]]) / 6;
}

/// Volume per region of the mesh, after checking what fill_volume guarantees: exact positive volumes, faces shared by
/// two tets of one region or on the surface, every side of every triangle taken by its region. `unfilled` are excepted.
inline std::map<std::uint32_t, double> check_filling(const Surface& surface, const VolumeMesh& mesh,
                                                     const std::set<std::uint32_t>& unfilled = {}) {
  const std::vector<Vec3> points = all_points(surface, mesh);
  std::map<std::uint32_t, double> volumes;
  std::map<std::array<std::uint32_t, 3>, std::vector<std::pair<std::uint32_t, std::uint32_t>>>
      face_to_tets;  // apex, region
  REQUIRE(mesh.tet_to_region.size() == mesh.tet_to_vert.size());
  bool positive = true;
  for (std::size_t i = 0; i < mesh.tet_to_vert.size(); ++i) {
    const auto& t = mesh.tet_to_vert[i];
    for (const std::uint32_t v : t) REQUIRE(v < points.size());
    positive = positive && orient3d(points[t[0]], points[t[1]], points[t[2]], points[t[3]]) > 0;
    volumes[mesh.tet_to_region[i]] += volume_of(points, t);
    for (int apex = 0; apex < 4; ++apex) {
      std::array face{t[(apex + 1) % 4], t[(apex + 2) % 4], t[(apex + 3) % 4]};
      std::sort(face.begin(), face.end());
      face_to_tets[face].emplace_back(t[apex], mesh.tet_to_region[i]);
    }
  }
  CHECK(positive);
  std::size_t missing = 0, wrong = 0;
  for (std::size_t i = 0; i < surface.tri_to_vert.size(); ++i) {
    auto face = surface.tri_to_vert[i];
    const Vec3 &a = points[face[0]], &b = points[face[1]], &c = points[face[2]];
    std::sort(face.begin(), face.end());
    const auto& tets = face_to_tets[face];
    std::size_t expected = 0;
    for (const ModelRegionId side : {surface.tri_to_sides[i].front, surface.tri_to_sides[i].back}) {
      expected += side.valid() && !unfilled.count(side.value);
    }
    missing += tets.size() != expected;
    for (const auto& [apex, region] : tets) {
      const FaceSides& sides = surface.tri_to_sides[i];
      wrong += (orient3d(a, b, c, points[apex]) > 0 ? sides.front.value : sides.back.value) != region;
    }
    face_to_tets.erase(face);
  }
  CHECK(missing == 0);
  CHECK(wrong == 0);
  std::size_t unpaired = 0;
  for (const auto& [face, tets] : face_to_tets) unpaired += tets.size() != 2 || tets[0].second != tets[1].second;
  CHECK(unpaired == 0);
  return volumes;
}

}  // namespace tetloom::volume_tests
