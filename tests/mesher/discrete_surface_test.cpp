// Facet models (STL, OBJ) through the whole mesher: their faces have no parameter plane and are remeshed in space.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>

#include "core/discrete/discrete_model.hpp"
#include "core/mesh/quality.hpp"
#include "core/mesh/validate.hpp"
#include "mesher/mesher.hpp"
#include "mesher/surface/surface_mesher.hpp"
#include "tests/support/analytic_model.hpp"

using namespace tetloom;
using namespace tetloom::test_models;

namespace {

// The surface mesh of a smooth model, taken as a facet model.
std::unique_ptr<GeometricModel> facetted(const GeometricModel& model, double size) {
  const Mesh mesh = mesh_surface(model, SizeField::uniform(size), TaskRunner(1)).mesh;
  return make_discrete_model(mesh.points, mesh.tri_to_vert, 40 * std::numbers::pi / 180);
}

void check_remesh(const GeometricModel& facets, double size, double area) {
  const SurfaceMeshResult result = mesh_surface(facets, SizeField::uniform(size), TaskRunner(2));
  for (const Diagnostic& error : result.errors) FAIL_CHECK(error.message);
  CHECK(validate_mesh(result.mesh).problems.empty());
  CHECK(validate_mesh(result.mesh).open_edges == 0);
  const SizeField sizes = SizeField::uniform(size);
  const TriangleQuality quality = compute_quality(result.mesh, &sizes).triangles;
  CHECK(quality.area == Approx(area).epsilon(0.02));
  CHECK(quality.shape_mean > 0.93);
  CHECK(quality.min_angle_deg > 15);
  CHECK(quality.edges.mean_length_ratio == Approx(1).epsilon(0.1));
  CHECK(quality.edges.in_band > 0.9);
}

}  // namespace

TEST_CASE("a facetted sphere, which has no edge, is remeshed coarser and finer than its facets") {
  const auto facets = facetted(*make_sphere({0, 0, 0}, 1), 0.1);
  CHECK(facets->topology().edge_count() == 0);
  check_remesh(*facets, 0.2, 4 * std::numbers::pi);
  check_remesh(*facets, 0.06, 4 * std::numbers::pi);
}

TEST_CASE("a facetted box and a facetted cylinder keep their sharp edges") {
  const auto box = facetted(*make_box({0, 0, 0}, {1, 2, 1}), 0.25);
  CHECK(box->topology().face_count() == 6);
  check_remesh(*box, 0.12, 10);
  const auto cylinder = facetted(*make_cylinder(0.5, 1), 0.05);
  CHECK(cylinder->topology().face_count() == 3);
  check_remesh(*cylinder, 0.1, std::numbers::pi * 1.5);
}

TEST_CASE("an open surface that passes through itself is told of and asks for no smaller sizes") {
  constexpr std::uint32_t kAlong = 60, kAcross = 10;
  std::vector<Vec3> points;
  std::vector<std::array<std::uint32_t, 3>> triangles;
  for (std::uint32_t i = 0; i <= kAlong; ++i)
    for (std::uint32_t j = 0; j <= kAcross; ++j) {
      const double t = -1.4 + 2.8 * i / kAlong;  // the curve meets itself at t = 1 and t = -1
      points.push_back({t * t, 1.0 * j / kAcross, t * (t * t - 1)});
      if (i == kAlong || j == kAcross) continue;
      const std::uint32_t a = i * (kAcross + 1) + j, b = a + kAcross + 1;
      triangles.push_back({a, b, a + 1});
      triangles.push_back({b, b + 1, a + 1});
    }
  const auto ribbon = make_discrete_model(points, triangles, 40 * std::numbers::pi / 180);
  MeshOptions options;
  options.sizes.size = 0.11;
  const MeshResult result = make_mesh(*ribbon, options);
  CHECK(result.status == MeshStatus::Ok);
  CHECK(result.refinement.rounds == 0);
  CHECK(
      std::ranges::any_of(result.warnings, [](const Diagnostic& d) { return d.code == ErrorCode::SelfIntersection; }));
}

#ifdef TETLOOM_WORKER
TEST_CASE("a facet model is filled with tetrahedra") {
  MeshOptions options;
  options.sizes.size = 0.2;
  options.volume_worker = TETLOOM_WORKER;
  const auto facets = facetted(*make_cylinder(0.5, 1), 0.1);
  const MeshResult result = make_mesh(*facets, options);
  REQUIRE(result.status == MeshStatus::Ok);
  CHECK(validate_mesh(result.mesh).problems.empty());
  CHECK(compute_quality(result.mesh).tets.volume == Approx(result.model_volume).epsilon(0.03));
}
#endif
