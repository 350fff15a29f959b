// Fans of layers at sharp convex edges.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>

#include "tests/mesher/layers_fixture.hpp"
#include "tests/support/error_of.hpp"
#include "tetloom/model.hpp"

using namespace tetloom;
using namespace tetloom::test_layers;
using namespace tetloom::test_models;
using test::error_of;

namespace {

// The space around a body, with layers on all faces but those of the box.
struct Outside {
  std::unique_ptr<GeometricModel> model;
  MeshOptions options;

  Outside(std::shared_ptr<const GeometricModel> body, double factor, double size, const WallLayers& layers)
      : model(put_into_box(std::move(body), factor)), options(options_of_size(size)) {
    const auto faces = static_cast<std::uint32_t>(model->topology().face_count());
    options.layers = on_faces(*model, layers, {faces - 6, faces - 5, faces - 4, faces - 3, faces - 2, faces - 1});
  }
};

bool is_limited_by(const LayerFigures& figures, LayerLimit reason) {
  return std::ranges::any_of(figures.limited, [&](const LimitedLayers& limited) { return limited.reason == reason; });
}

}  // namespace

TEST_CASE("around a box every side has its layers, and fans lie between them") {
  const Outside around(make_box({0, 0, 0}, {1, 1, 1}), 3, 0.3, heights(0.015, 8));
  const MeshResult result = meshed(*around.model, around.options);
  const LayerFigures& figures = result.layers;
  CHECK(compute_quality(result.mesh).cells.volume == Approx(26).epsilon(1e-12));
  CHECK(figures.coverage.full_count == Approx(1));
  CHECK(figures.coverage.first_height_error < 1e-9);
  CHECK(figures.scaled_jacobian_p1 > 0.5);
  CHECK(figures.min_scaled_jacobian > 0.5);
  CHECK(figures.limited.empty());
  // Per piece of an edge seven hexahedra and a pyramid; per corner a tet.
  CHECK(figures.hexes == result.mesh.hex_to_vert.size());
  CHECK(figures.pyramids == result.mesh.pyramid_to_vert.size());
  CHECK(figures.hexes == 7 * figures.pyramids);
  CHECK(figures.tets == 8);
  CHECK(figures.fans == 8 + figures.pyramids - 12);
}

TEST_CASE("without fans there is one direction at a sharp edge") {
  Outside around(make_box({0, 0, 0}, {1, 1, 1}), 3, 0.3, heights(0.015, 8));
  around.options.layers.fan_angle = 0;
  const LayerFigures none = meshed(*around.model, around.options).layers;
  CHECK(none.fans == 0);
  CHECK(none.hexes == 0);
  around.options.layers.fan_angle = 91;
  CHECK(meshed(*around.model, around.options).layers.fans == 0);
}

TEST_CASE("at a trailing edge there are two elements between the sides") {
  const Outside around(bar({{0, 0}, {1, -0.3}, {1.2, 0}, {1, 0.3}}, 0.6), 3, 0.2, heights(0.01, 8));
  const MeshResult result = meshed(*around.model, around.options);
  CHECK(result.layers.coverage.at_least_one > 0.99);
  CHECK(result.layers.coverage.first_height_within_10pct > 0.99);
  CHECK(result.layers.scaled_jacobian_p1 > 0.4);
  CHECK(result.layers.fans > 10);
}

TEST_CASE("layers go around the rim of a sheet") {
  const Outside around(make_plate(1, 0.6), 2.5, 0.08, heights(0.004, 6));
  const MeshResult result = meshed(*around.model, around.options);
  CHECK(result.layers.coverage.area == Approx(1.2));
  CHECK(result.layers.coverage.full_count == Approx(1));
  CHECK(result.layers.scaled_jacobian_p1 > 0.45);
}

TEST_CASE("a fan ends where its edge ends at concave edges") {
  const auto block = bar({{0, 0}, {4, 0}, {4, 2}, {2, 2}, {2, 4}, {0, 4}}, 2);
  MeshOptions options = options_of_size(0.4);
  options.layers = on_faces(*block, heights(0.02, 8));
  const MeshResult result = meshed(*block, options);
  CHECK(compute_quality(result.mesh).cells.volume == Approx(24).epsilon(1e-12));
  CHECK(result.layers.fans > 0);
  CHECK(result.layers.coverage.at_least_one == Approx(1));
  CHECK(result.layers.coverage.first_height_within_10pct > 0.95);
}

TEST_CASE("a fan ends on a side face, with triangles in the first layer") {
  const auto block = bar({{0, 0}, {4, 0}, {4, 2}, {2, 2}, {2, 4}, {0, 4}}, 2);
  for (const bool all_tets : {false, true}) {
    MeshOptions options = options_of_size(0.4);
    options.layers = on_faces(*block, heights(0.02, 8), {0, 1});
    options.layers.all_tets = all_tets;
    const MeshResult result = meshed(*block, options);
    CHECK(compute_quality(result.mesh).cells.volume == Approx(24).epsilon(1e-12));
    CHECK(result.layers.fans > 0);
    CHECK(result.layers.coverage.at_least_one == Approx(1));
    if (!all_tets) CHECK(result.mesh.hex_to_vert.size() > 0);
  }
}

TEST_CASE("where there is no room for fans, there is one direction, and the reason is told") {
  const std::vector<std::shared_ptr<const GeometricModel>> bodies{make_box({0, 0, 0}, {1, 1, 1}),
                                                                  make_box({1.1, 0, 0}, {2, 1, 1})};
  const Outside around(combine(bodies), 3, 0.25, heights(0.0125, 8));
  const MeshResult result = meshed(*around.model, around.options);
  CHECK(result.layers.fans > 0);
  CHECK(result.layers.coverage.at_least_one > 0.99);
  CHECK((is_limited_by(result.layers, LayerLimit::Fan) || is_limited_by(result.layers, LayerLimit::Gap)));
}

TEST_CASE("fans are the same on any number of threads, and split into tets that fit") {
  Outside around(bar({{0, 0}, {1, 0}, {0, 0.8}}, 1), 2.5, 0.3, heights(0.015, 7));
  const Mesh whole = meshed(*around.model, around.options).mesh;
  around.options.threads = 1;
  CHECK(mesh_digest(meshed(*around.model, around.options).mesh) == mesh_digest(whole));
  around.options.layers.all_tets = true;
  const Mesh split = meshed(*around.model, around.options).mesh;
  CHECK(split.hex_to_vert.empty());
  CHECK(split.prism_to_vert.empty());
  CHECK(split.tet_to_vert.size() == whole.tet_to_vert.size() + 2 * whole.pyramid_to_vert.size() +
                                        3 * whole.prism_to_vert.size() + 6 * whole.hex_to_vert.size());
  CHECK(compute_quality(split).cells.volume == Approx(compute_quality(whole).cells.volume).epsilon(1e-12));
}

TEST_CASE("fans around random wedges are valid") {
  for (int i = 0; i < 6; ++i) {
    CAPTURE(i);
    const double height = 0.2 + 0.15 * i, lean = 0.3 * (i % 3);
    Outside around(bar({{0, 0}, {1, -height * 0.3}, {1.2 + lean, 0}, {1, height}}, 0.7 + 0.1 * i), 2.5, 0.35,
                   heights(0.02 + 0.01 * (i % 2), 4 + 2 * (i % 4), 1.1 + 0.1 * (i % 3)));
    const MeshResult result = meshed(*around.model, around.options);
    CHECK(result.layers.min_scaled_jacobian >= 0.02 * (1 - 1e-6));
    CHECK(compute_quality(result.mesh).cells.volume == Approx(around.model->volume(ModelRegionId(0u))).epsilon(1e-9));
  }
}

TEST_CASE("an angle of fans that cannot be is refused") {
  const auto box = make_box({0, 0, 0}, {1, 1, 1});
  for (const double angle : {-1.0, 10.0, 44.9, 181.0, std::nan(""), HUGE_VAL}) {
    MeshOptions options = options_of_size(0.3);
    options.layers = on_faces(*box, heights(0.01, 3));
    options.layers.fan_angle = angle;
    CHECK(error_of([&] { make_mesh(*box, options); }).code == ErrorCode::InvalidArgument);
  }
}
