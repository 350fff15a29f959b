// Proximity: gaps and walls are measured, neighbours at an angle are not.
#include <catch2/catch.hpp>

#include "tests/mesher/size_field_fixture.hpp"

namespace tetloom {
namespace {

using test_sizes::build;
using ModelPtr = std::shared_ptr<const GeometricModel>;

/// A solid with a triangle (0,0) (width,0) (0,height) as its section, one unit deep.
std::unique_ptr<GeometricModel> make_wedge(double width, double height) {
  const std::vector<Vec3> points = {{0, 0, 0}, {width, 0, 0}, {0, height, 0}, {0, 0, 1}, {width, 0, 1}, {0, height, 1}};
  const std::vector<std::vector<std::uint32_t>> rings = {
      {0, 2, 1}, {3, 4, 5}, {0, 1, 4, 3}, {1, 2, 5, 4}, {2, 0, 3, 5}};
  return test_models::make_polyhedron(points, rings);
}

}  // namespace

TEST_CASE("a thin wall gets the asked number of layers") {
  const auto wall = test_models::make_box({0, 0, 0}, {1, 1, 0.06});
  const SizeField field = build(*wall, {.size = 0.2, .proximity = 3});
  for (double x = 0.05; x < 1; x += 0.1) CHECK(field.size_at({x, 0.5, 0.03}) == Approx(0.02).epsilon(0.05));
  CHECK(build(*wall, {.size = 0.2}).is_uniform());
}

TEST_CASE("the gap between two boxes is resolved where they face each other, and only there") {
  const std::array<ModelPtr, 2> bodies{test_models::make_box({0, 0, 0}, {1, 1, 1}),
                                       test_models::make_box({1.1, 0, 0}, {2, 0.3, 1})};
  const auto model = test_models::combine(bodies);
  const SizeField field = build(*model, {.size = 0.25, .proximity = 2, .gradation = 1});
  CHECK(field.size_at({1, 0.15, 0.5}) == Approx(0.05).epsilon(0.1));
  CHECK(field.size_at({1.1, 0.15, 0.5}) == Approx(0.05).epsilon(0.1));
  CHECK(field.size_at({1, 0.15, 0.95}) == Approx(0.05).epsilon(0.1));
  CHECK(field.size_at({1, 0.9, 0.5}) == 0.25);
  CHECK(field.size_at({0, 0.5, 0.5}) == 0.25);
}

TEST_CASE("the wall of a hollow between a large sphere and a box is measured from both sides") {
  const std::array<ModelPtr, 2> bodies{test_models::make_sphere({0, 0, 0}, 1),
                                       test_models::make_box({1.04, -1, -1}, {2, 1, 1})};
  const auto model = test_models::combine(bodies);
  const SizeField field = build(*model, {.size = 0.4, .min_size = 0.01, .proximity = 2});
  CHECK(field.size_at({1, 0, 0}) == Approx(0.02).epsilon(0.25));
  CHECK(field.size_at({1.04, 0, 0}) == Approx(0.02).epsilon(0.25));
}

TEST_CASE("bodies in contact, adjacent faces and wedges are not gaps") {
  SECTION("contact") {
    const std::array<ModelPtr, 2> bodies{test_models::make_box({0, 0, 0}, {1, 1, 1}),
                                         test_models::make_box({1, 0, 0}, {2, 1, 1})};
    CHECK(build(*test_models::combine(bodies), {.size = 0.25, .proximity = 3}).is_uniform());
  }
  SECTION("a wedge of 45 degrees") { CHECK(build(*make_wedge(10, 10), {.size = 0.2, .proximity = 3}).is_uniform()); }
  SECTION("a cylinder whose diameter has room for the layers") {
    CHECK(build(*test_models::make_cylinder(1, 5), {.size = 0.4, .proximity = 3}).is_uniform());
  }
}

TEST_CASE("proximity is limited by the floor") {
  const auto wall = test_models::make_box({0, 0, 0}, {1, 1, 0.001});
  CHECK(build(*wall, {.size = 0.2, .proximity = 3}).smallest() == Approx(0.02));
  CHECK(build(*wall, {.size = 0.2, .min_size = 0.01, .proximity = 3}).smallest() == Approx(0.01));
}

}  // namespace tetloom
