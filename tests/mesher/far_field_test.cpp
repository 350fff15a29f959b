// The space around models.
#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>

#include "tests/support/analytic_model.hpp"
#include "tests/support/error_of.hpp"
#include "tests/support/faceless_model.hpp"
#include "tetloom/check.hpp"
#include "tetloom/mesh.hpp"
#include "tetloom/model.hpp"

using namespace tetloom;
using namespace tetloom::test_models;
using test::error_of;

namespace {

double meshed_volume(const GeometricModel& model, double size) {
  MeshOptions options;
  options.sizes.size = size;
  options.threads = 2;
  const MeshResult result = make_mesh(model, options);
  REQUIRE(result.status == MeshStatus::Ok);
  CHECK(validate_mesh(result.mesh).valid());
  return compute_quality(result.mesh).cells.volume;
}

}  // namespace

TEST_CASE("the space around a box is a box with a hole") {
  const auto model = put_into_box(make_box({0, 0, 0}, {1, 2, 3}), 3);
  CHECK(model->topology().face_count() == 12);
  CHECK(model->topology().edge_count() == 24);
  CHECK(model->topology().vertex_count == 16);
  CHECK(model->volume(ModelRegionId(0u)) == Approx(27 * 6 - 6));
  CHECK(model->bounding_box().lo == Vec3{-1, -2, -3});
  CHECK(model->bounding_box().hi == Vec3{2, 4, 6});
  CHECK(model->attributes(ModelFaceId(6u)).name == "far_field_1");
  CHECK(model->attributes(ModelRegionId(0u)).name == "far_field");
  CHECK(model->area(ModelFaceId(11u)) == Approx(3 * 6));
  for (std::uint32_t f = 6; f < 12; ++f) {
    const auto face = model->face_geometry(ModelFaceId(f));
    for (const ModelLoop& loop : model->topology().face_to_loops[f])
      for (const EdgeUse& use : loop) {
        const auto edge = model->edge_geometry(use.edge);
        for (const double t : {edge->range().lo, 0.3, edge->range().hi})
          CHECK(distance(face->evaluate(face->edge_parameters(use, t)), edge->evaluate(t)) < 1e-12);
      }
  }
  CHECK(meshed_volume(*model, 0.8) == Approx(27 * 6 - 6).epsilon(1e-9));
}

TEST_CASE("the space around several bodies is one region") {
  const std::vector<std::shared_ptr<const GeometricModel>> bodies{make_sphere({0, 0, 0}, 1),
                                                                  make_box({2, -1, -1}, {3, 1, 1})};
  const auto model = put_into_box(combine(bodies), 2);
  const double volume = 8 * 2 * 2 * 4 - 4 - 4 * std::numbers::pi / 3;
  CHECK(model->volume(ModelRegionId(0u)) == Approx(volume).epsilon(1e-3));
  CHECK(meshed_volume(*model, 0.35) == Approx(volume).epsilon(1e-2));
}

TEST_CASE("a body in another one is not outside") {
  const std::vector<std::shared_ptr<const GeometricModel>> bodies{make_box({0, 0, 0}, {4, 4, 4}),
                                                                  make_box({1, 1, 1}, {2, 2, 2})};
  CHECK(put_into_box(combine(bodies), 2)->topology().face_count() == 12);
}

TEST_CASE("a sheet has the space around it on both sides, in a box that is not flat") {
  const auto model = put_into_box(make_plate(2, 1), 3);
  const FaceSides& sides = model->topology().face_to_sides[0];
  CHECK(sides.front == ModelRegionId(0u));
  CHECK(sides.back == ModelRegionId(0u));
  CHECK(model->volume(ModelRegionId(0u)) == Approx(6 * 3 * 0.6));
}

TEST_CASE("faces that cannot be facetted bound the space around their body like any other") {
  const auto around = [](ErrorCode code) {
    return put_into_box(std::make_unique<FacelessModel>(make_box({0, 0, 0}, {1, 1, 1}), code), 3);
  };
  const auto model = around(ErrorCode::FaceFailed);
  CHECK(model->topology().face_count() == 12);
  CHECK(model->volume(ModelRegionId(0u)) == Approx(27 - 1));
  CHECK(error_of([&] { around(ErrorCode::OutOfMemory); }).code == ErrorCode::OutOfMemory);
}

TEST_CASE("boxes that are not larger than the model are refused") {
  for (const double factor : {1.0, 0.0, -2.0, HUGE_VAL, std::nan("")})
    CHECK(error_of([&] { put_into_box(make_box({0, 0, 0}, {1, 1, 1}), factor); }).code == ErrorCode::InvalidArgument);
  CHECK(error_of([] { put_into_box(nullptr, 2); }).code == ErrorCode::InvalidArgument);
}
