#pragma once
// Meshes of second order made from others, for tests of whatever handles meshes.
#include <functional>

#include "core/mesh/mid_nodes.hpp"
#include "tetloom/mesh_data.hpp"

namespace tetloom::test {

/// `mesh` with classified mid nodes, in the middle of their edges plus what `displacement` says there. Points need
/// entities.
inline Mesh with_mid_nodes(
    Mesh mesh, const std::function<Vec3(const Vec3&)>& displacement = [](const Vec3&) { return Vec3{}; }) {
  const auto edges = edges_of_elements(mesh);
  for (const auto& [a, b] : edges) {
    const Vec3 middle = 0.5 * (mesh.points[a] + mesh.points[b]);
    mesh.points.push_back(middle + displacement(middle));
    mesh.point_to_entity.emplace_back();
  }
  mesh.mid_to_vert = edges;
  classify_mid_nodes(mesh);
  return mesh;
}

}  // namespace tetloom::test
