#pragma once
// Layers on analytic models.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <vector>

#include "tests/support/analytic_model.hpp"
#include "tetloom/check.hpp"
#include "tetloom/mesh.hpp"

namespace tetloom::test_layers {

inline MeshOptions options_of_size(double size, int threads = 2) {
  MeshOptions options;
  options.sizes.size = size;
  options.threads = threads;
  return options;
}

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

/// Faces of a cylinder that are flat.
inline std::vector<std::uint32_t> caps_of(const GeometricModel& model, double radius) {
  std::vector<std::uint32_t> caps;
  for (std::uint32_t f = 0; f < model.topology().face_count(); ++f)
    if (std::abs(model.area(ModelFaceId(f)) - std::numbers::pi * radius * radius) < 1e-3) caps.push_back(f);
  return caps;
}

}  // namespace tetloom::test_layers
