// Bodies that touch in an edge or a vertex, and bodies that touch themselves there.
#include <catch2/catch.hpp>

#include "tests/adapt/kept_mesh.hpp"
#include "tests/adapt/random_tensors.hpp"
#include "tests/adapt/touching_blocks.hpp"
#include "tests/adapt/uniform_metric.hpp"
#include "tests/support/sanitized.hpp"
#include "tetloom/adapt.hpp"

using namespace tetloom;
using namespace tetloom::adapt;

namespace {

AdaptResult adapted_in_parts(const Mesh& mesh, const MetricField& metric, double tets_per_part = 0) {
  AdaptOptions options;
  options.tets_per_part = tets_per_part, options.threads = 2;
  AdaptResult result = adapt_mesh(mesh, metric, options);
  for (const Diagnostic& error : result.errors) FAIL_CHECK(error.message);
  REQUIRE(result.status == AdaptStatus::Ok);
  return result;
}

}  // namespace

TEST_CASE("bodies that touch in an edge or a vertex stay together", "[adapt]") {
  for (const TouchingShape& shape : kTouchingShapes) {
    for (const int cuts : {1, 3}) {
      const Mesh mesh = mesh_of(shape, cuts);
      for (const double h : {test::kSanitized ? 0.12 : 0.07, 0.4})
        for (const double tets_per_part : {0.0, 300.0}) {
          CAPTURE(shape.name, cuts, h, tets_per_part);
          const AdaptResult result = adapted_in_parts(mesh, test::uniform_metric(mesh, h), tets_per_part);
          test::check_kept(mesh, result.mesh);
        }
    }
  }
}

TEST_CASE("random metrics leave bodies that touch valid, and together", "[adapt]") {
  RandomTensors random(7);
  for (const TouchingShape& shape : kTouchingShapes) {
    const Mesh mesh = mesh_of(shape, 2);
    std::vector<Tensor> tensors;
    for (std::size_t v = 0; v < mesh.points.size(); ++v)
      tensors.push_back(compose(random.metric(random.uniform(0.3, 2), 100)));
    MetricField metric = metric_from_tensors(tensors, mesh.points);
    scale_to_complexity(metric, {mesh.points, mesh.tet_to_vert}, 200);
    CAPTURE(shape.name);
    test::check_kept(mesh, adapted_in_parts(mesh, metric, 400).mesh);
  }
}

TEST_CASE("edges at which bodies touch become as short as others", "[adapt]") {
  for (const TouchingShape& shape : kTouchingShapes) {
    CAPTURE(shape.name);
    const Mesh mesh = mesh_of(shape, 1);
    const AdaptResult result = adapted_in_parts(mesh, test::uniform_metric(mesh, test::kSanitized ? 0.075 : 0.06));
    test::check_kept(mesh, result.mesh);
    const MetricConformity& after = result.report.after;
    CAPTURE(after.unit, after.half_to_two, after.shortest, after.longest, after.mean_quality, after.least_quality);
    CHECK(after.unit > 0.98);
    CHECK(after.longest < 2);
    CHECK(after.mean_quality > 0.85);
    CHECK(after.least_quality > 0.2);
  }
}

TEST_CASE("fields are carried over where bodies touch", "[adapt]") {
  const auto linear = [](const Vec3& x) { return 3 + x.x - 2 * x.y + 4 * x.z; };
  for (const TouchingShape& shape : kTouchingShapes) {
    CAPTURE(shape.name);
    Mesh mesh = mesh_of(shape, 2);
    MeshField on_points{"linear", 2, {}}, on_tets{"mass", 1, std::vector<double>(mesh.tet_to_vert.size(), 2)};
    for (const Vec3& x : mesh.points) on_points.values.insert(on_points.values.end(), {linear(x), -linear(x)});
    mesh.point_fields = {on_points}, mesh.cell_fields = {on_tets};
    AdaptOptions options;
    options.transfer = {"linear", "mass"};
    const AdaptResult result = adapt_mesh(mesh, test::uniform_metric(mesh, 0.12), options);
    REQUIRE(result.status == AdaptStatus::Ok);
    REQUIRE(result.mesh.point_fields.size() == 1);
    REQUIRE(result.mesh.point_fields[0].values.size() == 2 * result.mesh.points.size());
    for (std::size_t v = 0; v < result.mesh.points.size(); ++v) {
      const double value = result.mesh.point_fields[0].values[2 * v];
      CHECK(std::abs(value - linear(result.mesh.points[v])) < 1e-12);
      CHECK(result.mesh.point_fields[0].values[2 * v + 1] == -value);
    }
    for (const double value : result.mesh.cell_fields.at(0).values) CHECK(std::abs(value - 2) < 1e-12);
  }
}
