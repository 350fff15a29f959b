// Facet models (STL, OBJ) through the whole mesher: their faces have no parameter plane and are remeshed in space.
#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <map>
#include <numbers>
#include <optional>
#include <random>
#include <string>

#include "mesher/surface/surface_mesher.hpp"
#include "tests/support/analytic_model.hpp"
#include "tetloom/check.hpp"
#include "tetloom/mesh.hpp"
#include "tetloom/model.hpp"
#include "tetloom/tasks.hpp"

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

TEST_CASE("a face of nearly no width beside large ones does not make the surface run away") {
  // A plate with a step across its top, a hundredth of a percent of its length high.
  const double step = 1e-3, w = 10;
  const std::vector<std::array<double, 2>> profile{{0, 0}, {w, 0}, {w, 1}, {5, 1}, {5, 1 + step}, {0, 1 + step}};
  std::vector<Vec3> points;
  for (const double y : {0.0, w})
    for (const auto& [x, z] : profile) points.push_back({x, y, z});
  std::vector<std::array<std::uint32_t, 3>> triangles;
  for (std::uint32_t i = 0; i < 6; ++i) {
    const std::uint32_t j = (i + 1) % 6;
    triangles.push_back({i, j, j + 6}), triangles.push_back({i, j + 6, i + 6});
  }
  for (const auto& t : {std::array{0u, 2u, 1u}, {0u, 3u, 2u}, {0u, 4u, 3u}, {0u, 5u, 4u}}) {
    triangles.push_back({t[0], t[2], t[1]}), triangles.push_back({t[0] + 6, t[1] + 6, t[2] + 6});
  }
  for (auto& t : triangles) std::swap(t[1], t[2]);
  const auto model = make_discrete_model(points, triangles, 40 * std::numbers::pi / 180);
  REQUIRE(model->topology().face_count() == 8);
  REQUIRE(model->topology().region_count() == 1);
  const double size = 0.2;
  const SurfaceMeshResult result = mesh_surface(*model, SizeField::uniform(size), TaskRunner(2));
  for (const Diagnostic& error : result.errors) FAIL_CHECK(error.message);
  CHECK(validate_mesh(result.mesh).problems.empty());
  const double expected = 240 / (0.433 * size * size);
  CHECK(static_cast<double>(result.mesh.tri_to_vert.size()) < 1.5 * expected);
  CHECK(compute_quality(result.mesh).triangles.area == Approx(240).epsilon(0.01));
}

TEST_CASE("a sharp edge that fades out in a smooth face stays sharp") {
  // A lens whose rim is a crease on one half and rounded on the other.
  const std::uint32_t columns = 48, rows = 16;
  std::vector<Vec3> points;
  std::vector<std::array<std::uint32_t, 3>> triangles;
  for (std::uint32_t j = 1; j < rows; ++j) {
    for (std::uint32_t i = 0; i < columns; ++i) {
      const double a = 2 * std::numbers::pi * i / columns, b = std::numbers::pi * (1.0 * j / rows - 0.5);
      const double sharp = 0.5 + 0.5 * std::cos(a);  // of the rim
      const double r = (1 - sharp) * std::cos(b) + sharp * (1 - std::abs(2 * b / std::numbers::pi));
      const double z = 0.4 * ((1 - sharp) * std::sin(b) + sharp * 2 * b / std::numbers::pi);
      points.push_back({r * std::cos(a), r * std::sin(a), z});
    }
  }
  const auto bottom = static_cast<std::uint32_t>(points.size()), top = bottom + 1;
  points.push_back({0, 0, -0.4}), points.push_back({0, 0, 0.4});
  for (std::uint32_t i = 0; i < columns; ++i) {
    const std::uint32_t k = (i + 1) % columns, last = (rows - 2) * columns;
    triangles.push_back({bottom, k, i}), triangles.push_back({top, last + i, last + k});
    for (std::uint32_t j = 0; j + 2 < rows; ++j) {
      const std::uint32_t p = j * columns + i, q = j * columns + k;
      triangles.push_back({p, q, q + columns}), triangles.push_back({p, q + columns, p + columns});
    }
  }
  const auto model = make_discrete_model(points, triangles, 40 * std::numbers::pi / 180);
  CHECK(model->topology().face_count() == 1);
  CHECK(model->topology().edge_count() > 0);
  const SurfaceMeshResult result = mesh_surface(*model, SizeField::uniform(0.06), TaskRunner(2));
  for (const Diagnostic& error : result.errors) FAIL_CHECK(error.message);
  CHECK(result.warnings.empty());
  CHECK(validate_mesh(result.mesh).open_edges == 0);
  CHECK(compute_quality(result.mesh).triangles.min_angle_deg > 10);
  double farthest = 0;
  for (const Vec3& p : result.mesh.points) farthest = std::max(farthest, p.x);
  CHECK(farthest > 0.995);
}

namespace {

// Two sheets over a sector, with a sharp corner where its straight sides meet; away from there they swell to a round
// rim.
std::unique_ptr<GeometricModel> make_sharp_leaf(double feature_angle) {
  constexpr int kRings = 24, kRays = 12;
  constexpr double kWidth = 1.05, kThin = 0.02, kThick = 1.2;
  std::vector<Vec3> points{{0, 0, 0}};
  std::map<std::array<int, 3>, std::uint32_t> known;
  const auto point = [&](int ring, int ray, int sheet) {
    if (ring == 0) return std::uint32_t{0};
    if (ray == 0 || ray == kRays || ring == kRings) sheet = 0;
    const auto [at, is_new] = known.try_emplace({ring, ray, sheet}, static_cast<std::uint32_t>(points.size()));
    if (is_new) {
      const double r = 1.0 * ring / kRings, across = 1.0 * ray / kRays, angle = (across - 0.5) * kWidth;
      const double slope = kThin + (kThick - kThin) * r * r;
      points.push_back({r * std::cos(angle), r * std::sin(angle),
                        sheet * r * slope * std::sin(std::numbers::pi * across) * std::sqrt(1 - r * r)});
    }
    return at->second;
  };
  std::vector<std::array<std::uint32_t, 3>> triangles;
  for (const int sheet : {1, -1})
    for (int i = 0; i < kRings; ++i)
      for (int j = 0; j < kRays; ++j) {
        const std::uint32_t a = point(i, j, sheet), b = point(i + 1, j, sheet), c = point(i + 1, j + 1, sheet),
                            d = point(i, j + 1, sheet);
        using Triangle = std::array<std::uint32_t, 3>;
        for (Triangle t : j < kRays / 2 ? std::array{Triangle{a, b, d}, Triangle{b, c, d}}
                                        : std::array{Triangle{a, b, c}, Triangle{a, c, d}}) {
          if (t[0] == t[1] || t[1] == t[2] || t[2] == t[0]) continue;
          if (sheet < 0) std::swap(t[1], t[2]);
          triangles.push_back(t);
        }
      }
  return make_discrete_model(points, triangles, feature_angle);
}

// A ring whose section is round and which is twisted so far that it passes through itself: a tube along an 8.
ModelDocument make_crossing_tube() {
  constexpr std::uint32_t kAlong = 96, kAround = 16;
  std::vector<Vec3> points;
  std::vector<std::array<std::uint32_t, 3>> triangles;
  for (std::uint32_t j = 0; j < kAlong; ++j)
    for (std::uint32_t i = 0; i < kAround; ++i) {
      const double t = 2 * std::numbers::pi * j / kAlong + 0.01, a = 2 * std::numbers::pi * i / kAround;
      const Vec3 along = normalized({2 * std::cos(t), 2 * std::cos(2 * t), 0.2 * std::cos(t + 1)});
      const Vec3 side = normalized(cross(along, {0, 0, 1})), up = cross(side, along);
      points.push_back(Vec3{2 * std::sin(t), std::sin(2 * t), 0.2 * std::sin(t + 1)} +
                       0.3 * (std::cos(a) * side - std::sin(a) * up));
      const std::uint32_t p = j * kAround + i, q = j * kAround + (i + 1) % kAround;
      const auto next = [&](std::uint32_t v) { return (v + kAround) % (kAlong * kAround); };
      triangles.push_back({p, q, next(q)}), triangles.push_back({p, next(q), next(p)});
    }
  ModelDocument document;
  document.model = make_discrete_model(points, triangles, 40 * std::numbers::pi / 180);
  return document;
}

// A valid mesh of the model, or a failure that says why there is none.
MeshResult fill(const GeometricModel& model, const MeshOptions& options) {
  MeshResult result = make_mesh(model, options);
  for (const Diagnostic& error : result.errors) FAIL_CHECK(error.message);
  REQUIRE(result.status == MeshStatus::Ok);
  CHECK(validate_mesh(result.mesh).problems.empty());
  return result;
}

}  // namespace

TEST_CASE("both sides of a sharp corner may belong to one face: no triangle lies on another one") {
  const auto leaf = make_sharp_leaf(100 * std::numbers::pi / 180);
  REQUIRE(leaf->topology().face_count() == 1);
  REQUIRE(leaf->topology().edge_count() == 2);
  for (const double size : {0.3, 0.15, 0.1, 0.05}) {
    CAPTURE(size);
    MeshOptions options;
    options.sizes.size = size;
    const MeshResult result = fill(*leaf, options);
    if (size <= 0.1) CHECK(compute_quality(result.mesh).tets.volume == Approx(result.model_volume).epsilon(0.05));
  }
}

TEST_CASE("a surface that touches itself in a point is meshed on both sides of it") {
  // A ring whose hole has shrunk to a point.
  constexpr std::uint32_t kAlong = 32, kAround = 24;
  std::vector<Vec3> points{{0, 0, 0}};
  std::vector<std::array<std::uint32_t, 3>> triangles;
  const auto point = [](std::uint32_t i, std::uint32_t j) {
    return j == 0 || j == kAround ? 0 : 1 + (j - 1) * kAlong + i % kAlong;
  };
  for (std::uint32_t j = 1; j < kAround; ++j)
    for (std::uint32_t i = 0; i < kAlong; ++i) {
      const double a = 2 * std::numbers::pi * i / kAlong, b = 2 * std::numbers::pi * j / kAround;
      points.push_back({(1 - std::cos(b)) * std::cos(a), (1 - std::cos(b)) * std::sin(a), -std::sin(b)});
    }
  for (std::uint32_t j = 0; j < kAround; ++j)
    for (std::uint32_t i = 0; i < kAlong; ++i) {
      const std::uint32_t a = point(i, j), b = point(i + 1, j), c = point(i + 1, j + 1), d = point(i, j + 1);
      if (a != b) triangles.push_back({a, b, c});
      if (c != d) triangles.push_back({a, c, d});
    }
  const auto horn = make_discrete_model(points, triangles, 40 * std::numbers::pi / 180);
  for (const double size : {0.3, 0.1}) {
    CAPTURE(size);
    MeshOptions options;
    options.sizes.size = size;
    const MeshResult result = fill(*horn, options);
    CHECK(compute_quality(result.mesh).tets.volume == Approx(result.model_volume).epsilon(0.05));
  }
}

TEST_CASE("a scan that passes through itself is known at once, and meshed when it is made anew") {
  const ModelDocument crossing = make_crossing_tube();
  MeshOptions options;
  options.sizes.size = 0.12;
  options.stop_where_model_crosses = true;
  const MeshResult first = make_mesh(*crossing.model, options);
  CHECK(first.stopped_early);
  CHECK(first.refinement.rounds == 0);
  const std::vector<ModelRegionId> regions = regions_that_cross(first, crossing.model->topology());
  REQUIRE(regions == std::vector{ModelRegionId(0)});
  const std::optional<ModelDocument> rebuilt = rebuild_solids(crossing, regions);
  REQUIRE(rebuilt.has_value());
  std::vector<std::string> digests;
  for (const int threads : {1, 2}) {
    options.threads = threads;
    const MeshResult result = fill(*rebuilt->model, options);
    CHECK(compute_quality(result.mesh).tets.volume == Approx(result.model_volume).epsilon(0.03));
    CHECK(result.model_volume < crossing.model->volume(ModelRegionId(0)));
    digests.push_back(mesh_digest(result.mesh));
  }
  CHECK(digests[0] == digests[1]);
}

#ifdef TETLOOM_WORKER
TEST_CASE("a scan of a blob, with noise, is filled with tetrahedra") {
  // What marching cubes make of r = 1 + bumps: facets of even size, noise of a fifth of an edge.
  std::mt19937 random(3);
  std::uniform_real_distribution<double> noise(-0.5, 0.5);
  const auto sphere = facetted(*make_sphere({0, 0, 0}, 1), 0.05);
  const Tessellation facets = sphere->face_geometry(ModelFaceId(0))->tessellate(1, 1);
  std::vector<Vec3> points = facets.points;
  for (Vec3& p : points) p = (1 + 0.1 * std::sin(4 * p.x) * std::cos(3 * p.y) + 0.008 * noise(random)) * p;
  const auto model = make_discrete_model(points, facets.tri_to_vert, 40 * std::numbers::pi / 180);
  MeshOptions options;
  options.sizes.relative_size = 1.0 / 20;
  options.sizes.curvature = 24;
  options.volume_worker = TETLOOM_WORKER;
  const MeshResult result = make_mesh(*model, options);
  REQUIRE(result.status == MeshStatus::Ok);
  CHECK(validate_mesh(result.mesh).problems.empty());
  CHECK(compute_quality(result.mesh).tets.volume == Approx(result.model_volume).epsilon(0.02));
  CHECK(compute_quality(result.mesh).triangles.min_angle_deg > 20);
}

TEST_CASE("a solid whose own facets pass through each other is refused after four rounds, with the place") {
  const auto sphere = facetted(*make_sphere({0, 0, 0}, 1), 0.1);
  const Tessellation facets = sphere->face_geometry(ModelFaceId(0))->tessellate(1, 1);
  std::vector<Vec3> points = facets.points;
  // The top is pushed down, out of the bottom.
  for (Vec3& p : points)
    if (p.z > 0) p.z -= 5 * std::max(0.0, 0.5 - std::hypot(p.x, p.y));
  const auto model = make_discrete_model(points, facets.tri_to_vert, 40 * std::numbers::pi / 180);
  MeshOptions options;
  options.sizes.size = 0.2;
  options.volume_worker = TETLOOM_WORKER;
  const MeshResult result = make_mesh(*model, options);
  CHECK(result.status == MeshStatus::Failed);
  REQUIRE_FALSE(result.errors.empty());
  CHECK(result.errors[0].code == ErrorCode::SelfIntersection);
  REQUIRE(result.errors[0].point.has_value());
  CHECK(result.errors[0].point->z < 0);
  CHECK(result.refinement.rounds == 4);
}

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
