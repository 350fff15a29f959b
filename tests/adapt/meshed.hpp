#pragma once
// Meshes of models, for tests of what becomes of them.
#include <catch2/catch.hpp>
#include <utility>

#include "tetloom/mesh.hpp"

namespace tetloom::test {

/// Of one size, also where that is too much for the shape.
inline Mesh meshed(const GeometricModel& model, double h) {
  MeshOptions options;
  options.sizes.size = h;
  options.refine_surface = false;
  MeshResult result = make_mesh(model, options);
  REQUIRE(result.status == MeshStatus::Ok);
  return std::move(result.mesh);
}

inline double volume_of(const Mesh& mesh) {
  double sum = 0;
  for (const auto& [a, b, c, d] : mesh.tet_to_vert) {
    const Vec3& x = mesh.points[a];
    sum += dot(cross(mesh.points[b] - x, mesh.points[c] - x), mesh.points[d] - x) / 6;
  }
  return sum;
}

}  // namespace tetloom::test
