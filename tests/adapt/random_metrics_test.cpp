// Any metric on any number of parts leaves a mesh of the same shape.
#include <algorithm>
#include <cmath>
#include <memory>
#include <string>

#include "tests/adapt/kept_mesh.hpp"
#include "tests/adapt/meshed.hpp"
#include "tests/adapt/random_tensors.hpp"
#include "tests/support/analytic_model.hpp"
#include "tests/support/mixed_mesh.hpp"
#include "tetloom/adapt.hpp"
#include "tetloom/check.hpp"

using namespace tetloom;
using namespace tetloom::adapt;

namespace {

enum class Shape { TwoRegions, Frame, Hollow };
enum class Kind { Noise, Jumps, Rotation };
constexpr const char* kShapes[] = {"two regions", "frame", "hollow"};
constexpr const char* kKinds[] = {"noise", "jumps", "rotation"};

using Ring = std::vector<std::uint32_t>;

/// The corners of the box from -a to a, bit 0 of the index: x, 1: y, 2: z, the z times `flat`.
void add_box(std::vector<Vec3>& points, double a, double flat = 1) {
  for (int i = 0; i < 8; ++i)
    points.push_back({(i & 1) != 0 ? a : -a, (i & 2) != 0 ? a : -a, ((i & 4) != 0 ? a : -a) * flat});
}

const Ring kSides[] = {{0, 4, 6, 2}, {1, 3, 7, 5}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 2, 3, 1}, {4, 5, 7, 6}};

Ring shifted(const Ring& ring, bool turned) {
  Ring result;
  for (const std::uint32_t v : ring) result.push_back(v + 8);
  if (turned) std::reverse(result.begin(), result.end());
  return result;
}

/// A square ring of material, of Euler characteristic 0.
std::unique_ptr<GeometricModel> make_frame() {
  std::vector<Vec3> points;
  add_box(points, 1, 0.3), add_box(points, 0.5, 0.6);
  std::vector<Ring> faces(kSides, kSides + 4);
  for (int i = 0; i < 4; ++i) faces.push_back(shifted(kSides[i], true));
  // Of bottom and top what lies between two edges.
  const std::uint32_t around[] = {0, 1, 3, 2};
  for (std::uint32_t i = 0; i < 4; ++i) {
    const std::uint32_t a = around[i], b = around[(i + 1) % 4];
    faces.push_back({b, a, a + 8, b + 8});
    faces.push_back({a + 4, b + 4, b + 12, a + 12});
  }
  return test_models::make_polyhedron(points, faces);
}

/// A box with a cavity, of Euler characteristic 2.
std::unique_ptr<GeometricModel> make_hollow() {
  std::vector<Vec3> points;
  add_box(points, 1), add_box(points, 0.4);
  std::vector<Ring> faces(std::begin(kSides), std::end(kSides));
  for (const Ring& side : kSides) faces.push_back(shifted(side, true));
  return test_models::make_polyhedron(points, faces);
}

Mesh mesh_of(Shape shape) {
  if (shape == Shape::TwoRegions) {
    test::BoxSpec spec{6, 6, 6, true, 1};
    spec.h = 1.0 / 6;
    return test::make_tet_box(spec);
  }
  return test::meshed(shape == Shape::Frame ? *make_frame() : *make_hollow(), 0.3);
}

/// Sizes that differ by up to `aspect`, on average such that about 10 * `complexity` tets are asked for.
MetricField random_metric(const Mesh& mesh, Kind kind, double aspect, double complexity, unsigned seed) {
  RandomTensors random(seed);
  const Vec3 normal = normalized(random.vector()), axis = normalized(random.vector());
  const double offset = random.uniform(-0.2, 0.2), turns = random.uniform(1, 3);
  const Tensor sides[2] = {compose(random.metric(1, aspect)), compose(random.metric(1, aspect))};
  const EigenSystem one{{1, aspect, aspect * aspect}, random.basis()};
  std::vector<Tensor> tensors;
  for (const Vec3& x : mesh.points) {
    if (kind == Kind::Noise) tensors.push_back(compose(random.metric(random.uniform(0.3, 2), aspect)));
    if (kind == Kind::Jumps) tensors.push_back(sides[dot(normal, x) > offset ? 1 : 0]);
    if (kind != Kind::Rotation) continue;
    EigenSystem turned = one;
    const double angle = turns * dot(normal, x), c = std::cos(angle), s = std::sin(angle);
    for (Vec3& v : turned.vectors) v = c * v + s * cross(axis, v) + (1 - c) * dot(axis, v) * axis;
    tensors.push_back(compose(turned));
  }
  MetricField metric = metric_from_tensors(tensors, mesh.points);
  scale_to_complexity(metric, {mesh.points, mesh.tet_to_vert}, complexity);
  return metric;
}

void check_metric(Shape shape, Kind kind, double aspect, double tets_per_part, unsigned seed) {
  const std::string what = std::string(kShapes[static_cast<int>(shape)]) + ", " + kKinds[static_cast<int>(kind)];
  CAPTURE(what, aspect, tets_per_part, seed);
  const Mesh mesh = mesh_of(shape);
  const std::string digest = mesh_digest(mesh);
  const MetricField metric = random_metric(mesh, kind, aspect, 300, seed);
  AdaptOptions options;
  options.tets_per_part = tets_per_part, options.threads = 2;
  const AdaptResult result = adapt_mesh(mesh, metric, options);
  for (const Diagnostic& error : result.errors) FAIL_CHECK(error.message);
  REQUIRE(result.status == AdaptStatus::Ok);
  test::check_kept(mesh, result.mesh);
  CHECK(mesh_digest(mesh) == digest);
  CHECK(result.report.after.least_quality > 0);
  CHECK(result.report.most_parts >= (tets_per_part > 0 ? 2u : 1u));
}

}  // namespace

TEST_CASE("shapes of these tests are what they are taken for", "[short]") {
  CHECK(test::euler_characteristic(mesh_of(Shape::TwoRegions)) == 1);
  CHECK(test::euler_characteristic(mesh_of(Shape::Frame)) == 0);
  CHECK(test::euler_characteristic(mesh_of(Shape::Hollow)) == 2);
}

TEST_CASE("random metrics leave a valid mesh of the same shape", "[short]") {
  const Shape shape = GENERATE(Shape::TwoRegions, Shape::Frame, Shape::Hollow);
  for (const Kind kind : {Kind::Noise, Kind::Jumps, Kind::Rotation})
    for (const double aspect : {10.0, kind == Kind::Rotation ? 1e3 : 1e4}) check_metric(shape, kind, aspect, 400, 1);
}

TEST_CASE("random metrics leave a valid mesh of the same shape, in one part", "[short]") {
  for (const Kind kind : {Kind::Noise, Kind::Jumps}) check_metric(Shape::Frame, kind, 1e4, 0, 1);
}

TEST_CASE("a metric that turns faster than elements can is limited, and the rest followed", "[short]") {
  const Mesh mesh = mesh_of(Shape::TwoRegions);
  const double aspect = GENERATE(1e2, 1e3, 1e4);
  for (unsigned seed = 1; seed < 4; ++seed) {
    CAPTURE(aspect, seed);
    const AdaptResult result = adapt_mesh(mesh, random_metric(mesh, Kind::Rotation, aspect, 60, seed), {});
    REQUIRE(result.status == AdaptStatus::Ok);
    const TurningResult& turning = result.report.turning;
    CHECK(turning.turns);
    CHECK(turning.followed <= 4.4 * turning.asked);
    CHECK(static_cast<double>(result.mesh.tet_to_vert.size()) < 1.5 * expected_tets(turning.followed));
    const MetricConformity& after = result.report.after;
    CAPTURE(after.unit, after.half_to_two, after.shortest, after.longest, after.mean_quality, after.least_quality);
    CHECK(after.unit > 0.9);
    CHECK(after.longest < 3);
    CHECK(after.mean_quality > 0.8);
    CHECK(after.least_quality > 0.1);
  }
}

TEST_CASE("noise leaves no points in one place", "[short]") {
  const Mesh mesh = mesh_of(Shape::Frame);
  const AdaptResult result = adapt_mesh(mesh, random_metric(mesh, Kind::Noise, 1e4, 300, 3), {});
  REQUIRE(result.status == AdaptStatus::Ok);
  CHECK(result.report.after.least_quality > 1e-4);
  CHECK(result.report.after.shortest > 1e-4);
}

TEST_CASE("many random metrics leave valid meshes of the same shape", "[long]") {
  RandomTensors random(20);
  for (unsigned seed = 2; seed < 60; ++seed) {
    const auto shape = static_cast<Shape>(random.uniform(0, 3));
    const auto kind = static_cast<Kind>(random.uniform(0, 3));
    const double aspect = std::pow(1e4, random.uniform(0, 1));
    check_metric(shape, kind, aspect, random.uniform(0, 1) < 0.25 ? 0 : random.uniform(150, 500), seed);
  }
}
