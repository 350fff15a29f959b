// Options that are refused, estimates of the mesh, and refusals of what cannot fit in memory.
#include <catch2/catch.hpp>

#include <cmath>
#include <memory>
#include <numbers>

#include "mesher/volume/volume_mesher.hpp"
#include "tests/mesher/size_field_fixture.hpp"
#include "tests/support/faceless_model.hpp"
#include "tetloom/tasks.hpp"

namespace tetloom {
namespace {

using Catch::Matchers::Contains;
using test_sizes::build;
using test_sizes::refusal;
using test_sizes::unit_box;

std::unique_ptr<GeometricModel> faceless_cylinder(ErrorCode code) {
  return std::make_unique<test_models::FacelessModel>(test_models::make_cylinder(1, 2), code);
}

}  // namespace

TEST_CASE("options out of range are refused by name") {
  const auto model = unit_box();
  struct Case {
    const char* option;
    double SizeOptions::*member;
  };
  const Case cases[] = {{"size", &SizeOptions::size},           {"relative_size", &SizeOptions::relative_size},
                        {"min_size", &SizeOptions::min_size},   {"curvature", &SizeOptions::curvature},
                        {"proximity", &SizeOptions::proximity}, {"gradation", &SizeOptions::gradation}};
  for (const Case& c : cases)
    for (const double value : {-1.0, std::nan(""), HUGE_VAL, -HUGE_VAL}) {
      INFO(c.option << " = " << value);
      SizeOptions options;
      options.*c.member = value;
      CHECK_THAT(refusal(*model, options, ErrorCode::InvalidArgument), Catch::Matchers::StartsWith(c.option));
    }
  CHECK_THAT(refusal(*model, {.gradation = 0}, ErrorCode::InvalidArgument), Contains("gradation"));
  CHECK_THAT(refusal(*model, {.curvature = 2.5}, ErrorCode::InvalidArgument), Contains("curvature"));
  CHECK_THAT(refusal(*model, {.relative_size = 1.5}, ErrorCode::InvalidArgument), Contains("relative_size"));
}

TEST_CASE("wishes for entities and points that do not exist are refused by name") {
  const auto model = unit_box();
  const auto entity = [&](ModelEntity e, double size) {
    return refusal(*model, {.entity_sizes = {{ModelFaceId(std::size_t{0}), 0.1}, {e, size}}},
                   ErrorCode::InvalidArgument);
  };
  CHECK_THAT(entity({2, 6}, 0.1), Contains("entity_sizes[1].entity.index"));
  CHECK_THAT(entity({3, 1}, 0.1), Contains("entity_sizes[1].entity.index"));
  CHECK_THAT(entity({0, 8}, 0.1), Contains("entity_sizes[1].entity.index"));
  CHECK_THAT(entity({4, 0}, 0.1), Contains("entity_sizes[1].entity.dim"));
  for (const double size : {0.0, -1.0, std::nan(""), HUGE_VAL})
    CHECK_THAT(entity({2, 0}, size), Contains("entity_sizes[1].size"));
  CHECK_THAT(refusal(*model, {.point_sizes = {{{0, 0, 0}, 0}}}, ErrorCode::InvalidArgument),
             Contains("point_sizes[0].size"));
  CHECK_THAT(refusal(*model, {.point_sizes = {{{0, std::nan(""), 0}, 1}}}, ErrorCode::InvalidArgument),
             Contains("point_sizes[0].point"));
  const std::vector<SizeRefinement> refinements{{{}, -1}};
  CHECK_THAT(refusal(*model, {}, ErrorCode::InvalidArgument, refinements), Contains("refinements[0]"));
}

TEST_CASE("faces whose geometry fails give no sizes, but the edges still do") {
  const SizedModel sized =
      test_sizes::build_and_estimate(*faceless_cylinder(ErrorCode::FaceFailed), {.size = 0.5, .curvature = 24});
  CHECK(sized.sizes.size_at({1, 0, 0}) == Approx(std::sqrt(27.0) / 24).epsilon(0.05));
  CHECK(sized.sizes.size_at({1, 0, 1}) > 0.4);
  CHECK(sized.estimate.tets > 100);
  CHECK(refusal(*faceless_cylinder(ErrorCode::Cancelled), {.size = 0.5, .curvature = 24}, ErrorCode::Cancelled) ==
        "no such surface");
}

TEST_CASE("a model without extent is refused") {
  const auto point = test_models::make_box({1, 1, 1}, {1, 1, 1});
  CHECK_THAT(refusal(*point, {.size = 1}, ErrorCode::InputUnsuitable), Contains("extent"));
}

TEST_CASE("the estimate counts what a mesh of one size holds") {
  const double h = 0.05, pi = std::numbers::pi;
  const auto sphere = test_models::make_sphere({0, 0, 0}, 1);
  const MeshEstimate estimate = estimate_mesh(*sphere, SizeField::uniform(h), TaskRunner(2));
  CHECK(estimate.triangles == Approx(4 * pi * 2.3094 / (h * h)).epsilon(0.001));
  CHECK(estimate.tets == Approx(4 * pi / 3 * 9.3 / (h * h * h)).epsilon(0.001));
  CHECK(estimate.bytes == Approx(800 * estimate.triangles + 65 * estimate.tets));
  CHECK(surface_part(estimate).tets == 0);
  CHECK(surface_part(estimate).bytes == Approx(800 * estimate.triangles));
  CHECK(estimate_mesh(*test_models::make_plate(1, 2), SizeField::uniform(h), TaskRunner(1)).tets == 0);
}

TEST_CASE("the estimate integrates graded sizes") {
  const auto box = unit_box();
  SizeOptions options{.size = 0.2, .gradation = 1};
  options.callback = [](const Vec3& x) { return 0.02 + 0.1 * x.x; };
  const SizedModel sized = test_sizes::build_and_estimate(*box, options);
  const double a = 0.02, b = 0.12;
  const double mean2 = 1 / (a * b), mean3 = (1 / (a * a) - 1 / (b * b)) / (2 * (b - a));
  CHECK(sized.estimate.tets == Approx(9.3 * mean3).epsilon(0.1));
  CHECK(sized.estimate.triangles == Approx(2.3094 * (4 * mean2 + 1 / (a * a) + 1 / (b * b))).epsilon(0.1));
  SECTION("the same with the field alone") {
    const MeshEstimate again = estimate_mesh(*box, sized.sizes, TaskRunner(2));
    CHECK(again.tets == Approx(sized.estimate.tets).epsilon(0.02));
    CHECK(again.triangles == Approx(sized.estimate.triangles).epsilon(0.02));
  }
  SECTION("and it leaves out what lies outside of the regions") {
    const std::vector<Vec3> corners = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    const std::vector<std::vector<std::uint32_t>> rings = {{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}};
    const auto tetrahedron = test_models::make_polyhedron(corners, rings);
    SizeOptions region{.size = 0.2, .entity_sizes = {{ModelRegionId(std::size_t{0}), 0.02}}};
    const SizedModel small = test_sizes::build_and_estimate(*tetrahedron, region);
    CHECK(small.estimate.tets == Approx(9.3 / 6 / std::pow(0.02, 3)).epsilon(0.1));
  }
}

TEST_CASE("absurd sizes are refused before anything is built, with the numbers") {
  const auto model = unit_box();
  CHECK_THAT(refusal(*model, {.size = 1e-9}, ErrorCode::OutOfMemory), Contains("triangles") && Contains("GB"));
  CHECK_THAT(
      refusal(*model, {.size = 0.1, .entity_sizes = {{ModelFaceId(std::size_t{2}), 1e-9}}}, ErrorCode::OutOfMemory),
      Contains("triangles"));
  const auto sphere = test_models::make_sphere({0, 0, 0}, 1);
  CHECK_THAT(refusal(*sphere, {.size = 0.1, .min_size = 1e-7, .curvature = 1e7}, ErrorCode::OutOfMemory),
             Contains("triangles"));
  CHECK_THAT(
      refusal(*model, {.size = 0.1, .entity_sizes = {{ModelEdgeId(std::size_t{2}), 1e-9}}}, ErrorCode::OutOfMemory),
      Contains("triangles"));
}

TEST_CASE("a tree that outgrows its memory is given up") {
  SizeOptions options{.size = 0.2};
  for (int i = 0; i < 50; ++i) options.point_sizes.push_back({{0.02 * i, 0.5, 0.5}, 1e-4});
  try {
    build_size_field(*unit_box(), options, {}, TaskRunner(1), 1'000'000);
    FAIL("nothing was thrown");
  } catch (const Error& error) {
    CHECK(error.code() == ErrorCode::OutOfMemory);
    CHECK_THAT(error.what(), Contains("size field"));
  }
}

TEST_CASE("a limit on memory is kept, and room enough is not refused") {
  const MeshEstimate estimate{.triangles = 1e6, .tets = 1e7, .bytes = 5.5e9};
  CHECK_THROWS_AS(check_memory(estimate, 5'000'000'000), Error);
  CHECK_NOTHROW(check_memory(estimate, 6'000'000'000));
  CHECK_NOTHROW(check_memory({.triangles = 10, .tets = 10, .bytes = 1000}, 0));
  CHECK(available_memory() > 1'000'000);
  try {
    check_memory(estimate, 5'000'000'000);
  } catch (const Error& error) {
    CHECK(error.code() == ErrorCode::OutOfMemory);
    CHECK_THAT(error.what(), Contains("1e+06 triangles") && Contains("1e+07 tetrahedra") && Contains("5.5 GB"));
  }
  const auto model = unit_box();
  CHECK(estimate_least_mesh(*model, {.size = 0.1}).triangles == Approx(600 * 2.3094).epsilon(0.001));
}

}  // namespace tetloom
