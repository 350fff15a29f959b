#include "tests/adapt/uniform_metric.hpp"
#include "tetloom/metric.hpp"
#include "tetloom/tasks.hpp"

#include <catch2/catch.hpp>
#include <cmath>

#include "tests/support/analytic_model.hpp"
#include "tests/support/error_of.hpp"

using namespace tetloom;
using namespace tetloom::adapt;
using test::error_of;

namespace {

constexpr double kPi = 3.14159265358979323846;

/// A strip of triangles on face `face` through `points`.
Mesh strip_on(std::uint32_t face, const std::vector<Vec3>& points) {
  Mesh mesh;
  mesh.points = points;
  for (std::uint32_t i = 0; i + 2 < points.size(); ++i) {
    mesh.tri_to_vert.push_back({i, i + 1, i + 2});
    mesh.tri_to_entity.push_back(face);
  }
  return mesh;
}

double size_along(const MetricField& metric, std::size_t vert, const Vec3& direction) {
  return std::sqrt(norm2(direction) / dot(metric.at(vert), direction));
}

std::vector<Vec3> helix(double radius, double height) {
  std::vector<Vec3> points;
  for (int i = 0; i < 12; ++i)
    points.push_back({radius * std::cos(0.4 * i + 0.1), radius * std::sin(0.4 * i + 0.1), height * (0.1 + 0.07 * i)});
  return points;
}

}  // namespace

TEST_CASE("the metric follows a cylinder around, not along", "[curvature_limits]") {
  const auto model = test_models::make_cylinder(2, 5);
  const Mesh mesh = strip_on(0, helix(2, 5));
  MetricField metric = test::uniform_metric(mesh, 1);
  const TaskRunner runner(2);
  CHECK(limit_by_curvature(metric, mesh, *model, {24, 0}, runner) == mesh.points.size());
  for (std::size_t v = 0; v < mesh.points.size(); ++v) {
    const Vec3 p = mesh.points[v];
    CHECK(size_along(metric, v, {-p.y, p.x, 0}) == Approx(6 * 2 / 24.).epsilon(1e-4));
    CHECK(size_along(metric, v, {0, 0, 1}) == Approx(1).epsilon(1e-6));
    CHECK(size_along(metric, v, {p.x, p.y, 0}) == Approx(1).epsilon(1e-6));
  }
  // What is finer already stays bit for bit, and no size goes below the limit.
  MetricField fine = test::uniform_metric(mesh, 0.3);
  const MetricField before = fine;
  CHECK(limit_by_curvature(fine, mesh, *model, {24, 0}, runner) == 0);
  CHECK(fine.logs == before.logs);
  MetricField limited = test::uniform_metric(mesh, 1);
  limit_by_curvature(limited, mesh, *model, {24, 0.8}, runner);
  CHECK(size_along(limited, 3, {-mesh.points[3].y, mesh.points[3].x, 0}) == Approx(0.8).epsilon(1e-4));
}

TEST_CASE("the metric follows a sphere in its tangent planes", "[curvature_limits]") {
  const auto model = test_models::make_sphere({1, 2, 3}, 2);
  std::vector<Vec3> points;
  for (int i = 0; i < 10; ++i) {
    const double theta = 0.3 + 0.25 * i, phi = 0.6 * i;
    points.push_back(Vec3{1, 2, 3} +
                     2 * Vec3{std::sin(theta) * std::cos(phi), std::sin(theta) * std::sin(phi), std::cos(theta)});
  }
  const Mesh mesh = strip_on(0, points);
  MetricField metric = test::uniform_metric(mesh, 3), alone = metric;
  limit_by_curvature(metric, mesh, *model, {12, 0}, TaskRunner(2));
  limit_by_curvature(alone, mesh, *model, {12, 0}, TaskRunner(1));
  CHECK(metric.logs == alone.logs);
  for (std::size_t v = 0; v < points.size(); ++v) {
    const Vec3 n = points[v] - Vec3{1, 2, 3}, t = cross(n, {0.3, 0.5, 0.8});
    const double expected = 6 * 2 / (12 * std::sqrt(3.0));
    CHECK(size_along(metric, v, t) == Approx(expected).epsilon(1e-6));
    CHECK(size_along(metric, v, cross(n, t)) == Approx(expected).epsilon(1e-6));
    CHECK(size_along(metric, v, n) == Approx(3).epsilon(1e-6));
  }
}

TEST_CASE("the metric follows curved edges of flat faces", "[curvature_limits]") {
  const auto model = test_models::make_annulus(1, 3);
  Mesh mesh;
  for (int i = 0; i < 8; ++i) mesh.points.push_back({3 * std::cos(kPi / 4 * i), 3 * std::sin(kPi / 4 * i), 0});
  for (int i = 0; i < 8; ++i) mesh.points.push_back({std::cos(kPi / 4 * i), std::sin(kPi / 4 * i), 0});
  // Whichever of the model's edges is the outer one: found by a point of it.
  const auto edge_at = [&](double radius) {
    for (std::uint32_t e = 0; e < 2; ++e)
      if (std::abs(norm(model->edge_geometry(ModelEdgeId(e))->evaluate(0.1)) - radius) < 1e-9) return e;
    return kNone;
  };
  for (std::uint32_t i = 0; i < 8; ++i) {
    mesh.edge_to_vert.push_back({i, (i + 1) % 8});
    mesh.edge_to_entity.push_back(edge_at(3));
    mesh.edge_to_vert.push_back({8 + i, 8 + (i + 1) % 8});
    mesh.edge_to_entity.push_back(edge_at(1));
    mesh.tri_to_vert.push_back({i, (i + 1) % 8, 8 + i});
    mesh.tri_to_entity.push_back(0);
  }
  MetricField metric = test::uniform_metric(mesh, 2);
  limit_by_curvature(metric, mesh, *model, {24, 0}, TaskRunner(1));
  CHECK(size_along(metric, 0, {0, 1, 0}) == Approx(3 * std::sqrt(27.0) / 24).epsilon(1e-6));
  CHECK(size_along(metric, 8, {0, 1, 0}) == Approx(std::sqrt(27.0) / 24).epsilon(1e-6));
  CHECK(size_along(metric, 0, {1, 0, 0}) == Approx(2).epsilon(1e-6));
  CHECK(size_along(metric, 8, {0, 0, 1}) == Approx(2).epsilon(1e-6));
}

TEST_CASE("curvature limits refuse what does not fit together", "[curvature_limits]") {
  const auto model = test_models::make_box({0, 0, 0}, {1, 1, 1});
  Mesh mesh = strip_on(0, {{0, 0, 0}, {0, 1, 0}, {0, 0, 1}});
  MetricField metric = test::uniform_metric(mesh, 1);
  const TaskRunner runner(1);
  CHECK(limit_by_curvature(metric, mesh, *model, {}, runner) == 0);
  mesh.tri_to_entity[0] = kNone;
  CHECK(limit_by_curvature(metric, mesh, *model, {}, runner) == 0);
  mesh.tri_to_entity[0] = 6;
  const Diagnostic error = error_of([&] { limit_by_curvature(metric, mesh, *model, {}, runner); });
  CHECK(error.code == ErrorCode::InputUnsuitable);
  CHECK_THAT(error.message, Catch::Contains("face 7") && Catch::Contains("only 6"));
  mesh.tri_to_entity[0] = 0;
  for (const CurvatureLimits& bad : {CurvatureLimits{0, 0}, CurvatureLimits{24, -1}, CurvatureLimits{NAN, 0}})
    CHECK(error_of([&] { limit_by_curvature(metric, mesh, *model, bad, runner); }).code == ErrorCode::InvalidArgument);
  metric.logs.pop_back();
  CHECK(error_of([&] { limit_by_curvature(metric, mesh, *model, {}, runner); }).code == ErrorCode::InvalidArgument);
}
