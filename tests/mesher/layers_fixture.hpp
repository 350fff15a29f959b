#pragma once
// Layers on analytic models.
#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstdint>
#include <memory>
#include <numbers>
#include <vector>

#include "tests/mesher/options_of_size.hpp"
#include "tests/support/analytic_model.hpp"
#include "tetloom/check.hpp"
#include "tetloom/mesh.hpp"

namespace tetloom::test_layers {

using test_models::options_of_size;

/// Layers on all faces but some.
inline LayerOptions on_faces(const GeometricModel& model, WallLayers layers, std::vector<std::uint32_t> but = {}) {
  LayerOptions options;
  for (std::uint32_t f = 0; f < model.topology().face_count(); ++f) {
    layers.face = ModelFaceId(f);
    if (std::ranges::count(but, f) == 0) options.walls.push_back(layers);
  }
  return options;
}

inline WallLayers heights(double first, int count, double growth = 1.2) {
  WallLayers layers;
  layers.first_height = first;
  layers.count = count;
  layers.growth = growth;
  return layers;
}

inline MeshResult meshed(const GeometricModel& model, const MeshOptions& options) {
  MeshResult result = make_mesh(model, options);
  REQUIRE(result.status == MeshStatus::Ok);
  CHECK(validate_mesh(result.mesh).valid());
  CHECK(compute_quality(result.mesh).cells.inverted == 0);
  return result;
}

/// A bar from y = 0 to `length` whose ring in x-z is counter-clockwise seen from -y.
inline std::unique_ptr<GeometricModel> bar(const std::vector<std::array<double, 2>>& ring, double length) {
  std::vector<Vec3> points;
  for (const double y : {0.0, length})
    for (const auto& [x, z] : ring) points.push_back({x, y, z});
  const auto n = static_cast<std::uint32_t>(ring.size());
  std::vector<std::vector<std::uint32_t>> faces(2);
  for (std::uint32_t i = 0; i < n; ++i) {
    const std::uint32_t j = (i + 1) % n;
    faces[0].push_back(i);
    faces[1].push_back(2 * n - 1 - i);
    faces.push_back({j, i, i + n, j + n});
  }
  return test_models::make_polyhedron(points, faces);
}

/// Faces of a cylinder that are flat.
inline std::vector<std::uint32_t> caps_of(const GeometricModel& model, double radius) {
  std::vector<std::uint32_t> caps;
  for (std::uint32_t f = 0; f < model.topology().face_count(); ++f)
    if (std::abs(model.area(ModelFaceId(f)) - std::numbers::pi * radius * radius) < 1e-3) caps.push_back(f);
  return caps;
}

}  // namespace tetloom::test_layers
