// Refinement that follows a model.
#include <catch2/catch.hpp>
#include <cmath>

#include "tests/adapt/meshed.hpp"
#include "tests/adapt/uniform_metric.hpp"
#include "tests/support/analytic_model.hpp"
#include "tetloom/adapt.hpp"
#include "tetloom/check.hpp"

using namespace tetloom;
using test::meshed;
using test::volume_of;

namespace {

constexpr double kPi = 3.14159265358979323846;

AdaptResult adapted(const Mesh& mesh, double h, const GeometricModel* model, double tets_per_part = 0) {
  AdaptOptions options;
  options.model = model, options.tets_per_part = tets_per_part;
  const auto metric = test::uniform_metric(mesh, h);
  return adapt_mesh(mesh, metric, options);
}

Mesh led_to(const Mesh& mesh, double h, const GeometricModel& model) {
  AdaptResult result = adapted(mesh, h, &model);
  for (const Diagnostic& error : result.errors) FAIL_CHECK(error.message);
  REQUIRE(result.status == AdaptStatus::Ok);
  const ValidationReport validation = validate_mesh(result.mesh);
  for (const MeshProblem& problem : validation.problems) FAIL_CHECK(problem.message);
  CHECK(result.report.after.unit > 0.9);
  CHECK(result.report.after.least_quality > 0.05);
  return std::move(result.mesh);
}

/// The largest distance of a point from the face or edge that it is classified on.
template <class DistanceTo>
double farthest(const Mesh& mesh, const DistanceTo& distance_to) {
  double most = 0;
  for (std::size_t v = 0; v < mesh.points.size(); ++v) {
    const ModelEntity entity = mesh.point_to_entity[v];
    if (entity.dim <= 2) most = std::max(most, distance_to(entity, mesh.points[v]));
  }
  return most;
}

/// Halves the size of the mesh of `model` from `h` on, and demands that its points lie on it and that its volume
/// converges at second order.
template <class DistanceTo>
void check_halvings(const GeometricModel& model, double h, int times, double volume, const DistanceTo& distance_to) {
  Mesh mesh = meshed(model, h);
  double last = std::abs(volume_of(mesh) - volume);
  for (int i = 0; i < times; ++i) {
    h /= 2;
    CAPTURE(i, h);
    mesh = led_to(mesh, h, model);
    CHECK(farthest(mesh, distance_to) <= 1e-7);
    const double off = std::abs(volume_of(mesh) - volume);
    CHECK(off < last / 3);
    last = off;
  }
}

}  // namespace

TEST_CASE("a refined sphere stays a sphere", "[snapping]") {
  const Vec3 center{1, 2, 3};
  check_halvings(*test_models::make_sphere(center, 1), 0.6, 3, 4 * kPi / 3,
                 [&](ModelEntity, const Vec3& x) { return std::abs(distance(x, center) - 1); });
}

TEST_CASE("a refined cylinder stays a cylinder", "[snapping]") {
  const auto off = [](ModelEntity entity, const Vec3& x) {
    const double side = std::abs(std::hypot(x.x, x.y) - 1), ends = std::min(std::abs(x.z), std::abs(x.z - 2));
    if (entity.dim == 2) return entity.index == 0 ? side : ends;
    return entity.dim == 1 && entity.index == 2 ? side : std::max(side, ends);
  };
  check_halvings(*test_models::make_cylinder(1, 2), 0.7, 3, 2 * kPi, off);
}

TEST_CASE("a sphere becomes coarser and stays on the model", "[snapping]") {
  const auto sphere = test_models::make_sphere({}, 1);
  const Mesh mesh = led_to(meshed(*sphere, 0.2), 0.4, *sphere);
  CHECK(farthest(mesh, [](ModelEntity, const Vec3& x) { return std::abs(norm(x) - 1); }) < 1e-7);
  CHECK(volume_of(mesh) > 0.9 * 4 * kPi / 3);
}

TEST_CASE("without a model a curved surface stays as it is", "[snapping]") {
  const auto sphere = test_models::make_sphere({}, 1);
  const Mesh mesh = meshed(*sphere, 0.5);
  const AdaptResult result = adapted(mesh, 0.3, nullptr);
  REQUIRE(result.status == AdaptStatus::Ok);
  CHECK(validate_mesh(result.mesh).valid());
  CHECK(volume_of(result.mesh) == Approx(volume_of(mesh)).epsilon(1e-12));
}

TEST_CASE("a model that does not match the mesh is refused", "[snapping]") {
  const auto sphere = test_models::make_sphere({}, 1);
  const Mesh mesh = meshed(*sphere, 0.5);
  const auto refusal = [&](const Mesh& input, const GeometricModel& model) {
    const AdaptResult result = adapted(input, 0.3, &model);
    CHECK(result.status == AdaptStatus::Failed);
    CHECK(result.mesh.points.empty());
    REQUIRE(result.errors.size() == 1);
    CHECK(result.errors[0].code == ErrorCode::InputUnsuitable);
    return result.errors[0];
  };
  SECTION("elsewhere") {
    const Diagnostic error = refusal(mesh, *test_models::make_sphere({0.3, 0, 0}, 1));
    CHECK(error.point);
    CHECK_FALSE(error.entities.empty());
  }
  SECTION("of another size") { refusal(mesh, *test_models::make_sphere({}, 1.1)); }
  SECTION("with fewer entities") {
    const Mesh box = meshed(*test_models::make_box({-1, -1, -1}, {1, 1, 1}), 0.5);
    const Diagnostic error = refusal(box, *sphere);
    CHECK_THAT(error.message, Catch::Contains("the model has only"));
  }
  SECTION("that the mesh names no edges of") {
    const auto box_model = test_models::make_box({-1, -1, -1}, {1, 1, 1});
    Mesh box = meshed(*box_model, 0.5);
    box.edge_to_vert.clear(), box.edge_to_entity.clear();
    const Diagnostic error = refusal(box, *box_model);
    CHECK_THAT(error.message, Catch::Contains("names no edge"));
    CHECK(error.point);
  }
}

TEST_CASE("a few vertices beside the model, as where a small feature was eliminated, come back to it", "[snapping]") {
  const auto sphere = test_models::make_sphere({}, 1);
  Mesh mesh = meshed(*sphere, 0.3);
  int moved = 0;
  for (std::size_t v = 0; v < mesh.points.size(); v += 9) {
    if (mesh.point_to_entity[v].dim != 2) continue;
    mesh.points[v] = 0.94 * mesh.points[v];
    ++moved;
  }
  REQUIRE(moved > 3);
  const Mesh back = led_to(mesh, 0.3, *sphere);
  CHECK(farthest(back, [](ModelEntity, const Vec3& x) { return std::abs(norm(x) - 1); }) < 1e-7);
}

TEST_CASE("what comes out goes in again, where edges are long for the curvature", "[snapping]") {
  const auto model = test_models::make_cylinder(1, 2);
  Mesh mesh = meshed(*model, 0.8);
  AdaptOptions options;
  options.model = model.get();
  for (int cycle = 0; cycle < 8; ++cycle) {
    CAPTURE(cycle);
    // A layer that turns, with long edges elsewhere.
    const double turn = 0.4 * cycle;
    const auto metric = [=](const Vec3& x) {
      const Vec3 n{std::cos(turn), std::sin(turn), 0.3};
      const double h = 0.03 + 0.5 * std::abs(dot(x, n) - 0.2);
      return adapt::isotropic(0.9) + (1 / (h * h) / dot(n, n)) * adapt::outer(n);
    };
    AdaptResult result = adapt_mesh(mesh, metric, options);
    for (const Diagnostic& error : result.errors) FAIL_CHECK(error.message);
    REQUIRE(result.status == AdaptStatus::Ok);
    CHECK(validate_mesh(result.mesh).valid());
    CHECK(result.report.beside_model == 0);
    mesh = std::move(result.mesh);
  }
}

TEST_CASE("a mesh that follows a model does not depend on threads", "[snapping]") {
  const auto cylinder = test_models::make_cylinder(1, 2);
  const Mesh mesh = meshed(*cylinder, 0.4);
  const auto metric = test::uniform_metric(mesh, 0.15);
  std::vector<std::vector<Vec3>> points;
  for (const int threads : {1, 4}) {
    AdaptOptions options;
    options.model = cylinder.get(), options.threads = threads, options.tets_per_part = 2000;
    const AdaptResult result = adapt_mesh(mesh, metric, options);
    REQUIRE(result.status == AdaptStatus::Ok);
    CHECK(result.report.most_parts > 2);
    points.push_back(result.mesh.points);
  }
  CHECK(points[0] == points[1]);
}
