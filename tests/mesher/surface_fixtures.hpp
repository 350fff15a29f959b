#pragma once
// Small tet meshes with a surface that may change, for the tests of what changes it.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <functional>
#include <random>
#include <set>
#include <utility>
#include <vector>

#include "mesher/intersection/self_intersection.hpp"
#include "mesher/tets/surface_geometry.hpp"
#include "tests/support/tet_fixtures.hpp"

namespace tetloom::tet_tests {

struct TestSurface {
  std::vector<tets::TriangleVerts> tri_to_vert;
  std::vector<std::uint32_t> tri_to_face;
  std::vector<ModelEntity> point_to_entity;
  std::function<bool(std::uint32_t, std::uint32_t)> is_kept;
  SurfaceProjector project;
  std::function<bool(const tets::SurfaceChange&)> is_clear;

  tets::ChangeableSurface view() { return {tri_to_vert, tri_to_face, point_to_entity, is_kept, project, is_clear}; }

  /// Whether the fixed faces of the mesh are these triangles.
  bool matches(const TetMesh& mesh) const {
    std::set<tets::TriangleVerts> own, faces;
    for (const tets::TriangleVerts& triangle : tri_to_vert) own.insert(tets::sorted(triangle).verts);
    for (const auto& face : fixed_faces(mesh)) faces.insert(face);
    return own == faces && own.size() == tri_to_vert.size();
  }
  /// Of one model face, by the absolute area of each triangle.
  double area_of(const TetMesh& mesh, std::uint32_t face) const {
    double area = 0;
    for (std::size_t t = 0; t < tri_to_vert.size(); ++t) {
      const auto& [a, b, c] = tri_to_vert[t];
      if (tri_to_face[t] == face)
        area += 0.5 * norm(cross(mesh.points[b] - mesh.points[a], mesh.points[c] - mesh.points[a]));
    }
    return area;
  }
};

/// The fixed faces of a mesh, each once, seen from the outside of the tet with the lower id; `face_of` names the model
/// face of a triangle.
template <class FaceOf>
TestSurface surface_of(const TetMesh& mesh, FaceOf&& face_of) {
  TestSurface surface;
  for (const tets::FaceCode face : mesh.faces()) {
    if (!mesh.is_fixed(face) || mesh.behind(face) < face) continue;
    surface.tri_to_vert.push_back(tets::verts_of(mesh, face));
    surface.tri_to_face.push_back(face_of(surface.tri_to_vert.back(), surface.tri_to_face.size()));
  }
  return surface;
}

/// Model face 0 is what lies in the plane z = 0, up to a small height; every other triangle is a face of its own.
inline TestSurface flat_surface(const TetMesh& mesh) {
  return surface_of(mesh, [&](const tets::TriangleVerts& triangle, std::size_t id) {
    const auto flat = [&](std::uint32_t v) { return std::abs(mesh.points[v].z) < 1e-6; };
    return std::all_of(triangle.begin(), triangle.end(), flat) ? 0u : static_cast<std::uint32_t>(id + 1);
  });
}

/// Two tets from `apex` to two triangles in the plane z = 0, at the edge from (-1, 0, 0) to (1, 0, 0); the other points
/// are (0, +-width, 0) / 2. `two_sides`: two more below, of the other region.
inline TetMesh make_diamond(const Vec3& apex = {0, 0, 0.8}, bool two_sides = false, double width = 1) {
  std::vector<Vec3> points{{-1, 0, 0}, {1, 0, 0}, {0, 0.5 * width, 0}, {0, -0.5 * width, 0}, apex};
  std::vector<std::array<std::uint32_t, 4>> tets{{0, 1, 2, 4}, {1, 0, 3, 4}};
  if (!two_sides) return make_tets(points, tets);
  points.push_back({apex.x, apex.y, -apex.z});
  tets.push_back({0, 1, 2, 5}), tets.push_back({1, 0, 3, 5});
  return make_tets(points, tets, {1, 1, 0, 0});
}

/// `count` tets around one half of the edge from (-1, 0, 0) to (1, 0, 0), the half above z = 0.
inline TetMesh make_half_ring(std::uint32_t count) {
  std::vector<Vec3> points{{-1, 0, 0}, {1, 0, 0}};
  std::vector<std::array<std::uint32_t, 4>> tets;
  for (std::uint32_t i = 0; i <= count; ++i) {
    const double angle = 3.14159265358979 * i / count;
    points.push_back({0, std::cos(angle), i == count ? 0 : std::sin(angle)});
    if (i > 0) tets.push_back({0, 1, i + 1, i + 2});
  }
  return make_tets(points, tets);
}

/// The model of a cube [0, n]^3: face 2 * axis (+ 1) is where the coordinate is 0 (n), face 6 the plane x = n / 2; edge
/// 9 * axis + 3 * i + j runs along an axis where the next two coordinates are i * n / 2 and j * n / 2.
inline SurfaceProjector project_on_cube(int n) {
  return [n](ModelEntity entity, const Vec3& x) -> std::optional<SurfaceSpot> {
    SurfaceSpot spot{x, {}};
    if (entity.dim == 1) {
      const int axis = static_cast<int>(entity.index / 9);
      spot.point[(axis + 1) % 3] = 0.5 * n * (entity.index / 3 % 3);
      spot.point[(axis + 2) % 3] = 0.5 * n * (entity.index % 3);
      spot.direction[axis] = 1;
      return spot;
    }
    const int axis = entity.index == 6 ? 0 : static_cast<int>(entity.index / 2);
    spot.point[axis] = entity.index == 6 ? 0.5 * n : entity.index % 2 == 1 ? n : 0;
    spot.direction[axis] = entity.index == 6 || entity.index % 2 == 1 ? 1 : -1;
    return spot;
  };
}

/// A shaken grid whose surface points are shaken too, each within its face or along its edge.
struct CubeGrid {
  TetMesh mesh;
  std::uint32_t fixed_points = 0;
  TestSurface surface;

  std::uint32_t find(const Vec3& x) const {
    return static_cast<std::uint32_t>(std::find(mesh.points.begin(), mesh.points.end(), x) - mesh.points.begin());
  }
  /// Points that are not on what they are classified on.
  std::size_t misplaced_points() const {
    std::size_t count = 0;
    for (std::uint32_t v = 0; v < fixed_points; ++v) {
      const ModelEntity entity = surface.point_to_entity[v];
      count += entity.valid() && entity.dim > 0 && surface.project(entity, mesh.points[v])->point != mesh.points[v];
    }
    return count;
  }
};

/// The lowest entity of the cube's model at a grid point.
inline ModelEntity entity_on_cube(const Vec3& x, int n, int regions) {
  std::array<int, 3> place{};  // 0, 1 or 2 halves of n; -1 where free
  int fixed = 0;
  for (int axis = 0; axis < 3; ++axis) {
    const bool middle = regions == 2 && axis == 0 && 2 * x[axis] == n;
    place[axis] = x[axis] == 0 ? 0 : x[axis] == n ? 2 : middle ? 1 : -1;
    fixed += place[axis] >= 0;
  }
  if (fixed == 3) return ModelVertexId(0);
  for (int axis = 0; axis < 3; ++axis) {
    const int i = place[(axis + 1) % 3], j = place[(axis + 2) % 3];
    if (fixed == 2 && place[axis] < 0) return ModelEdgeId(static_cast<std::uint32_t>(9 * axis + 3 * i + j));
    if (fixed == 1 && place[axis] >= 0)
      return ModelFaceId(place[axis] == 1 ? 6u : static_cast<std::uint32_t>(2 * axis + place[axis] / 2));
  }
  return {};
}

inline CubeGrid make_cube_grid(int n, int regions, double shake, unsigned seed) {
  ShakenGrid plain = make_shaken_grid(n, regions, 0, seed);
  CubeGrid grid{std::move(plain.mesh), plain.fixed_points, {}};
  const std::vector<Vec3> at(grid.mesh.points.begin(), grid.mesh.points.end());
  grid.surface = surface_of(grid.mesh, [&](const tets::TriangleVerts& triangle, std::size_t) {
    const Vec3 middle = (at[triangle[0]] + at[triangle[1]] + at[triangle[2]]) / 3.0;
    const auto on = [&](int axis, double value) {
      return std::all_of(triangle.begin(), triangle.end(), [&](std::uint32_t v) { return at[v][axis] == value; });
    };
    for (int axis = 0; axis < 3; ++axis)
      if (on(axis, 0) || on(axis, n)) return static_cast<std::uint32_t>(2 * axis + (middle[axis] > 0));
    return 6u;
  });
  for (std::uint32_t v = 0; v < grid.fixed_points; ++v)
    grid.surface.point_to_entity.push_back(entity_on_cube(at[v], n, regions));
  grid.surface.project = project_on_cube(n);
  grid.surface.is_kept = [at, n, regions](std::uint32_t a, std::uint32_t b) {
    const ModelEntity middle = entity_on_cube(0.5 * (at[a] + at[b]), n, regions);
    return middle.valid() && middle.dim == 1 && distance(at[a], at[b]) == 1;
  };
  std::mt19937 random(seed);
  const auto amount = [&] { return shake * (static_cast<double>(random()) / 4294967296.0 - 0.5); };
  for (std::uint32_t v = 0; v < grid.fixed_points; ++v) {
    const ModelEntity entity = grid.surface.point_to_entity[v];
    const Vec3 moved = at[v] + Vec3{amount(), amount(), amount()};
    if (entity.dim > 0) grid.mesh.points[v] = grid.surface.project(entity, moved)->point;
  }
  return grid;
}

}  // namespace tetloom::tet_tests
