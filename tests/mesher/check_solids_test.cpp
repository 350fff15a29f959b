// Meshes whose volume is not the model's, and solids that are inside out or lie in each other.
#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <vector>

#include "tests/support/analytic_model.hpp"
#include "tetloom/mesh.hpp"

using namespace tetloom;
using namespace tetloom::test_models;

namespace {

using Bodies = std::vector<std::shared_ptr<const GeometricModel>>;

MeshResult mesh_of(const GeometricModel& model, double size, double curvature = 0, int threads = 2) {
  MeshOptions options;
  options.sizes.size = size;
  options.sizes.curvature = curvature;
  options.threads = threads;
  return make_mesh(model, options);
}

std::vector<Diagnostic> warnings_of(const MeshResult& result, ErrorCode code) {
  std::vector<Diagnostic> found;
  for (const Diagnostic& warning : result.warnings)
    if (warning.code == code) found.push_back(warning);
  return found;
}

std::vector<Diagnostic> overlaps_of(const Bodies& bodies, double size = 0.3, int threads = 2) {
  return warnings_of(mesh_of(*combine(bodies), size, 0, threads), ErrorCode::RegionsOverlap);
}

}  // namespace

TEST_CASE("a mesh whose volume is off by more than a hundredth is told with the solid, its faces and a point") {
  const Bodies bodies{make_box({-5, -1, -1}, {-3, 1, 1}), make_sphere({0, 0, 0}, 1)};
  const auto model = combine(bodies);
  const MeshResult coarse = mesh_of(*model, 0.9);
  REQUIRE(coarse.status == MeshStatus::Ok);
  const auto warnings = warnings_of(coarse, ErrorCode::VolumeDiffers);
  REQUIRE(warnings.size() == 1);
  REQUIRE(warnings[0].entities.size() == 2);
  CHECK(warnings[0].entities[0].entity == ModelEntity(ModelRegionId(1)));
  CHECK(warnings[0].entities[1].entity == ModelEntity(ModelFaceId(6)));
  REQUIRE(warnings[0].point);
  CHECK(norm(*warnings[0].point) == Approx(1).epsilon(0.3));
  CHECK_THAT(warnings[0].message, Catch::Contains("region 2") && Catch::Contains("4.18879") && Catch::Contains("%"));
  CHECK(warnings_of(mesh_of(*model, 0.9, 48), ErrorCode::VolumeDiffers).empty());
}

TEST_CASE("a solid that is inside out is told") {
  std::vector<Vec3> points;
  for (int i = 0; i < 8; ++i) points.push_back({double(i & 1), double(i >> 1 & 1), double(i >> 2)});
  std::vector<std::vector<std::uint32_t>> rings{{0, 4, 6, 2}, {1, 3, 7, 5}, {0, 1, 5, 4},
                                                {2, 6, 7, 3}, {0, 2, 3, 1}, {4, 5, 7, 6}};
  CHECK(warnings_of(mesh_of(*make_polyhedron(points, rings), 0.5), ErrorCode::RegionInsideOut).empty());
  for (auto& ring : rings) std::ranges::reverse(ring);
  const MeshResult result = mesh_of(*make_polyhedron(points, rings), 0.5);
  const auto warnings = warnings_of(result, ErrorCode::RegionInsideOut);
  REQUIRE(warnings.size() == 1);
  CHECK(warnings[0].entities.size() == 7);
  CHECK(warnings[0].point);
  CHECK(result.status == MeshStatus::Failed);
}

TEST_CASE("solids that lie in each other are told, and meshed each on its own") {
  const std::shared_ptr<const GeometricModel> box = make_box({0, 0, 0}, {2, 2, 2});
  struct Case {
    const char* name;
    Bodies bodies;
  };
  const std::vector<Case> cases{
      {"corner", {box, make_box({1.3, 1.3, 1.3}, {3, 3, 3})}},
      {"one inside", {make_box({0.6, 0.6, 0.6}, {1.4, 1.4, 1.4}), box}},
      {"crossed bars", {box, make_box({-2, 0.5, 0.5}, {4, 1.5, 1.5})}},
      {"half in a sphere", {make_sphere({0, 0, 0}, 1.2), box}},
  };
  for (const Case& one : cases) {
    INFO(one.name);
    const auto warnings = overlaps_of(one.bodies);
    REQUIRE(warnings.size() == 1);
    REQUIRE(warnings[0].entities.size() == 3);
    CHECK(warnings[0].entities[0].entity == ModelEntity(ModelRegionId(0)));
    CHECK(warnings[0].entities[1].entity == ModelEntity(ModelRegionId(1)));
    CHECK(warnings[0].entities[2].entity.dim == 2);
    CHECK(warnings[0].point);
    CHECK(overlaps_of(one.bodies, 0.3, 1)[0].point == warnings[0].point);
  }
}

TEST_CASE("solids that only touch, or stand apart, do not overlap") {
  const std::shared_ptr<const GeometricModel> box = make_box({0, 0, 0}, {2, 2, 2});
  CHECK(overlaps_of({box, make_box({2, 0, 0}, {4, 2, 2})}).empty());
  CHECK(overlaps_of({box, make_box({2, 0.7, 0.7}, {4, 1.1, 1.1})}).empty());
  CHECK(overlaps_of({box, make_box({1.99, 0, 0}, {4, 2, 2})}).empty());
  CHECK(overlaps_of({box, make_sphere({3, 1, 1}, 1)}).empty());
  CHECK(overlaps_of({make_torus(6, 1), box}).empty());
}
