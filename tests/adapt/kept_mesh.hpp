#pragma once
// What adaptation keeps of a mesh whose faces are plane, for tests.
#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <map>
#include <vector>

#include "tetloom/check.hpp"
#include "tetloom/mesh_data.hpp"

namespace tetloom::test {

/// Volumes of regions, areas of faces, lengths of edges and places of corners.
inline std::map<ModelEntity, double> extents(const Mesh& mesh) {
  std::map<ModelEntity, double> sums;
  const auto& x = mesh.points;
  for (std::size_t t = 0; t < mesh.tet_to_vert.size(); ++t) {
    const auto& [a, b, c, d] = mesh.tet_to_vert[t];
    sums[ModelEntity(3, mesh.tet_to_entity[t])] += dot(cross(x[b] - x[a], x[c] - x[a]), x[d] - x[a]) / 6;
  }
  for (std::size_t t = 0; t < mesh.tri_to_vert.size(); ++t) {
    const auto& [a, b, c] = mesh.tri_to_vert[t];
    sums[ModelEntity(2, mesh.tri_to_entity[t])] += norm(cross(x[b] - x[a], x[c] - x[a])) / 2;
  }
  for (std::size_t e = 0; e < mesh.edge_to_vert.size(); ++e)
    sums[ModelEntity(1, mesh.edge_to_entity[e])] += distance(x[mesh.edge_to_vert[e][0]], x[mesh.edge_to_vert[e][1]]);
  for (std::size_t v = 0; v < x.size(); ++v)
    if (mesh.point_to_entity[v].dim == 0)
      sums[mesh.point_to_entity[v]] += x[v].x + std::sqrt(2.0) * x[v].y + std::sqrt(3.0) * x[v].z;
  return sums;
}

/// The sum of the normals of each face's triangles, as long as their areas.
inline std::map<std::uint32_t, Vec3> face_normals(const Mesh& mesh) {
  std::map<std::uint32_t, Vec3> sums;
  for (std::size_t t = 0; t < mesh.tri_to_vert.size(); ++t) {
    const auto& [a, b, c] = mesh.tri_to_vert[t];
    sums[mesh.tri_to_entity[t]] += cross(mesh.points[b] - mesh.points[a], mesh.points[c] - mesh.points[a]) / 2;
  }
  return sums;
}

/// Vertices - edges + faces - tets.
inline long euler_characteristic(const Mesh& mesh) {
  std::vector<std::uint32_t> verts;
  std::vector<std::array<std::uint32_t, 2>> edges;
  std::vector<std::array<std::uint32_t, 3>> faces;
  for (auto v : mesh.tet_to_vert) {
    std::sort(v.begin(), v.end());
    for (std::size_t i = 0; i < 4; ++i) {
      verts.push_back(v[i]);
      faces.push_back({v[i == 0], v[i <= 1 ? 2 : 1], v[i <= 2 ? 3 : 2]});
      for (std::size_t j = 0; j < i; ++j) edges.push_back({v[j], v[i]});
    }
  }
  const auto count = [](auto& list) {
    std::sort(list.begin(), list.end());
    return static_cast<long>(std::unique(list.begin(), list.end()) - list.begin());
  };
  return count(verts) - count(edges) + count(faces) - static_cast<long>(mesh.tet_to_vert.size());
}

/// A valid mesh of the same regions, faces, edges and corners where they were.
inline void check_kept(const Mesh& before, const Mesh& after) {
  const ValidationReport validation = validate_mesh(after);
  for (const MeshProblem& problem : validation.problems) FAIL_CHECK(problem.message);
  CHECK(validation.unclassified_points == 0);
  CHECK(validation.unused_points == 0);
  CHECK(euler_characteristic(after) == euler_characteristic(before));
  const auto old = extents(before), now = extents(after);
  REQUIRE(now.size() == old.size());
  for (const auto& [entity, extent] : old) {
    CAPTURE(int{entity.dim}, entity.index);
    REQUIRE(now.count(entity) == 1);
    CHECK(std::abs(now.at(entity) - extent) <= 1e-12);
  }
  // On its own face, edge or corner: the triangles of a face have the normals that they had.
  const auto old_normals = face_normals(before), new_normals = face_normals(after);
  for (const auto& [face, normal] : old_normals) CHECK(distance(new_normals.at(face), normal) < 1e-12);
}

}  // namespace tetloom::test
