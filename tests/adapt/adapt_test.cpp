// Meshes led to a metric, without a model.
#include "tetloom/adapt.hpp"

#include <algorithm>
#include <atomic>
#include <catch2/catch.hpp>
#include <cmath>
#include <functional>
#include <limits>
#include <random>

#include "tests/adapt/kept_mesh.hpp"
#include "tests/adapt/random_tensors.hpp"
#include "tests/adapt/uniform_metric.hpp"
#include "tests/support/mixed_mesh.hpp"
#include "tetloom/check.hpp"
#include "tetloom/metric.hpp"

using namespace tetloom;
using adapt::Tensor;
using test::check_kept;
using test::extents;

namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

/// The plane in the middle is a face inside of one region.
Mesh cube_with_inner_face(int n) {
  Mesh mesh = test::make_unit_cube(n, true);
  for (std::uint32_t& region : mesh.tet_to_entity) region = 0;
  for (FaceSides& sides : mesh.face_to_sides)
    for (ModelRegionId* side : {&sides.front, &sides.back})
      if (side->valid()) *side = ModelRegionId(0);
  for (ModelEntity& entity : mesh.point_to_entity)
    if (entity.dim == 3) entity.index = 0;
  return mesh;
}

void check_conforms(const MetricConformity& conformity) {
  CHECK(conformity.unit > 0.95);
  CHECK(conformity.half_to_two > 0.999);
  CHECK(conformity.mean_quality > 0.85);
  CHECK(conformity.least_quality > 0.2);
}

AdaptResult adapted(const Mesh& mesh, const adapt::MetricField& metric, const AdaptOptions& options = {}) {
  AdaptResult result = adapt_mesh(mesh, metric, options);
  for (const Diagnostic& error : result.errors) FAIL_CHECK(error.message);
  REQUIRE(result.status == AdaptStatus::Ok);
  return result;
}

Diagnostic refusal(const Mesh& mesh, const adapt::MetricField& metric, const AdaptOptions& options = {}) {
  const AdaptResult result = adapt_mesh(mesh, metric, options);
  CHECK(result.status == AdaptStatus::Failed);
  CHECK(result.mesh.points.empty());
  CHECK(result.mesh.tet_to_vert.empty());
  REQUIRE(result.errors.size() == 1);
  return result.errors[0];
}

}  // namespace

TEST_CASE("a cube becomes finer and coarser", "[adapt]") {
  const auto [cubes, h] = GENERATE(std::pair(6, 0.08), std::pair(14, 0.2));
  CAPTURE(cubes, h);
  const Mesh cube = test::make_unit_cube(cubes);
  const AdaptResult result = adapted(cube, test::uniform_metric(cube, h));
  check_kept(cube, result.mesh);
  check_conforms(result.report.after);
  const double tets = adapt::expected_tets(1 / (h * h * h));
  CHECK(static_cast<double>(result.mesh.tet_to_vert.size()) > 0.5 * tets);
  CHECK(static_cast<double>(result.mesh.tet_to_vert.size()) < 1.5 * tets);
  CHECK(result.report.before.unit < result.report.after.unit);
  CHECK(result.report.rounds > 0);
  CHECK(result.report.most_parts == (h < 0.1 ? 2u : 1u));
  CHECK(result.report.operations.splits[0] + result.report.operations.collapses[0] > 0);
}

TEST_CASE("interfaces and faces inside of a region stay where they are", "[adapt]") {
  const bool inner = GENERATE(false, true);
  const auto [cubes, h] = GENERATE(std::pair(4, 0.12), std::pair(10, 0.25));
  CAPTURE(inner, cubes, h);
  const Mesh cube = inner ? cube_with_inner_face(cubes) : test::make_unit_cube(cubes, true);
  REQUIRE(validate_mesh(cube).valid());
  const AdaptResult result = adapted(cube, test::uniform_metric(cube, h));
  check_kept(cube, result.mesh);
  check_conforms(result.report.after);
}

TEST_CASE("without a model a bumpy face keeps its shape, beside straight edges too", "[adapt]") {
  const double h = GENERATE(0.11, 0.4);
  Mesh cube = test::make_unit_cube(5);
  for (Vec3& x : cube.points)
    if (x.z == 1 && x.x > 0 && x.x < 1 && x.y > 0 && x.y < 1) x.z += 0.04 * std::sin(9 * x.x + 5 * x.y);
  const AdaptResult result = adapted(cube, test::uniform_metric(cube, h));
  check_kept(cube, result.mesh);
}

TEST_CASE("layers of a hundredth of their length", "[adapt]") {
  const Mesh cube = test::make_unit_cube(8);
  const auto metric = [](const Vec3& x) {
    const double h = 0.004 + 0.2 * std::abs(x.z - 0.5);
    return adapt::diagonal(25, 25, 1 / (h * h));
  };
  const AdaptResult result = adapt_mesh(cube, metric, {});
  REQUIRE(result.status == AdaptStatus::Ok);
  check_kept(cube, result.mesh);
  check_conforms(result.report.after);
}

TEST_CASE("any metric leaves a valid mesh", "[adapt]") {
  const auto [seed, aspect, h] =
      GENERATE(std::tuple(1u, 10.0, 0.5), std::tuple(2u, 1e2, 2.0), std::tuple(3u, 1e4, 90.0));
  CAPTURE(seed, aspect);
  const Mesh cube = test::make_unit_cube(6, true);
  adapt::RandomTensors random(seed);
  std::vector<Tensor> tensors;
  for (std::size_t v = 0; v < cube.points.size(); ++v)
    tensors.push_back(compose(random.metric(h / aspect * random.uniform(0.3, 2), aspect)));
  const adapt::MetricField metric = adapt::metric_from_tensors(tensors, cube.points);
  REQUIRE(adapt::complexity(metric, {cube.points, cube.tet_to_vert}) < 1e4);
  const AdaptResult result = adapted(cube, metric);
  check_kept(cube, result.mesh);
  CHECK(result.report.after.least_quality > 1e-3);
  CHECK(result.report.after.unit > result.report.before.unit);
}

TEST_CASE("the mesh does not depend on threads, in any number of parts", "[adapt]") {
  const Mesh cube = test::make_unit_cube(6, true);
  std::vector<double> values;
  for (const Vec3& x : cube.points) values.push_back(0.03 + 0.15 * norm(x - Vec3{0.3, 0.4, 0.5}));
  const adapt::MetricField metric = adapt::metric_from_sizes(values, cube.points);
  std::string digest;
  for (const int threads : {1, 2, 4}) {
    AdaptOptions options;
    options.threads = threads, options.tets_per_part = 2000;
    const AdaptResult result = adapted(cube, metric, options);
    CHECK(result.report.most_parts > 3);
    if (digest.empty()) {
      check_kept(cube, result.mesh);
      check_conforms(result.report.after);
      digest = mesh_digest(result.mesh);
    }
    CHECK(mesh_digest(result.mesh) == digest);
  }
}

TEST_CASE("a metric from a callback is that of its values where it is constant", "[adapt]") {
  const Mesh cube = test::make_unit_cube(4);
  const AdaptResult from_values = adapted(cube, test::uniform_metric(cube, 0.15));
  const AdaptResult from_callback = adapt_mesh(cube, [](const Vec3&) { return adapt::isotropic(0.15); }, {});
  REQUIRE(from_callback.status == AdaptStatus::Ok);
  CHECK(from_callback.report.after.unit == Approx(from_values.report.after.unit).margin(0.02));
  check_kept(cube, from_callback.mesh);
}

TEST_CASE("gradation makes the mesh finer around what is fine", "[adapt]") {
  const Mesh cube = test::make_unit_cube(6);
  std::vector<double> values;
  for (const Vec3& x : cube.points) values.push_back(norm(x) < 0.1 ? 0.03 : 0.4);
  const adapt::MetricField metric = adapt::metric_from_sizes(values, cube.points);
  AdaptOptions graded;
  graded.gradation = 1.3;
  const AdaptResult with = adapted(cube, metric, graded), without = adapted(cube, metric);
  CHECK(with.mesh.tet_to_vert.size() > without.mesh.tet_to_vert.size());
  CHECK(with.report.before.complexity > without.report.before.complexity);
}

TEST_CASE("fields are carried over, linear ones exactly", "[adapt]") {
  Mesh cube = test::make_unit_cube(5);
  MeshField linear{"linear", 2, {}}, other{"other", 1, {}};
  for (const Vec3& x : cube.points) {
    linear.values.insert(linear.values.end(), {1 + x.x - 2 * x.y + 3 * x.z, 5 * x.z});
    other.values.push_back(x.x);
  }
  cube.point_fields = {linear, other};
  AdaptOptions options;
  options.transfer = {"linear"};
  const AdaptResult result = adapted(cube, test::uniform_metric(cube, 0.13), options);
  REQUIRE(result.mesh.point_fields.size() == 1);
  const MeshField& field = result.mesh.point_fields[0];
  CHECK(field.name == "linear");
  REQUIRE(field.values.size() == 2 * result.mesh.points.size());
  double worst = 0;
  for (std::size_t v = 0; v < result.mesh.points.size(); ++v) {
    const Vec3& x = result.mesh.points[v];
    worst = std::max({worst, std::abs(field.values[2 * v] - (1 + x.x - 2 * x.y + 3 * x.z)),
                      std::abs(field.values[2 * v + 1] - 5 * x.z)});
  }
  CHECK(worst < 1e-12);
}

TEST_CASE("options out of range are refused", "[adapt]") {
  const Mesh cube = test::make_unit_cube(2);
  const adapt::MetricField metric = test::uniform_metric(cube, 0.5);
  const auto code = [&](const auto& change) {
    AdaptOptions options;
    change(options);
    return refusal(cube, metric, options).code;
  };
  for (const double bad : {-0.1, 1.0, kNaN})
    CHECK(code([&](AdaptOptions& o) { o.quality_floor = bad; }) == ErrorCode::InvalidArgument);
  for (const double bad : {-1.0, 0.5, 1.0, kNaN})
    CHECK(code([&](AdaptOptions& o) { o.gradation = bad; }) == ErrorCode::InvalidArgument);
  for (const double bad : {-1.0, kNaN})
    CHECK(code([&](AdaptOptions& o) { o.tets_per_part = bad; }) == ErrorCode::InvalidArgument);
  CHECK(code([](AdaptOptions& o) { o.threads = -1; }) == ErrorCode::InvalidArgument);
  CHECK(code([](AdaptOptions& o) { o.transfer = {"heat"}; }) == ErrorCode::InvalidArgument);
}

TEST_CASE("metrics that do not fit are refused", "[adapt]") {
  const Mesh cube = test::make_unit_cube(2);
  adapt::MetricField metric = test::uniform_metric(cube, 0.5);
  SECTION("of another length") {
    metric.logs.pop_back();
    CHECK(refusal(cube, metric).code == ErrorCode::InvalidArgument);
  }
  SECTION("not a number") {
    metric.logs[4].xy = kNaN;
    const Diagnostic error = refusal(cube, metric);
    CHECK(error.code == ErrorCode::InputUnsuitable);
    CHECK(error.elements == std::vector<std::uint64_t>{4});
    CHECK(error.point == cube.points[4]);
  }
  SECTION("of a callback, not positive definite at a point") {
    const auto bad = [](const Vec3& x) { return x.x > 0.7 ? adapt::diagonal(4, -1, 4) : adapt::isotropic(0.5); };
    const AdaptResult result = adapt_mesh(cube, bad, {});
    REQUIRE(result.errors.size() == 1);
    CHECK(result.errors[0].code == ErrorCode::InputUnsuitable);
  }
  SECTION("of a callback that throws") {
    const auto bad = [](const Vec3&) -> Tensor { throw Error(ErrorCode::Internal, "nothing there"); };
    const AdaptResult result = adapt_mesh(cube, bad, {});
    REQUIRE(result.errors.size() == 1);
    CHECK(result.errors[0].message == "nothing there");
  }
  SECTION("that ask for more than any memory holds") {
    CHECK(refusal(cube, test::uniform_metric(cube, 1e-4)).code == ErrorCode::OutOfMemory);
    CHECK(refusal(cube, test::uniform_metric(cube, 1e-12)).code == ErrorCode::OutOfMemory);
    CHECK(refusal(cube, test::uniform_metric(cube, 1e-150)).code == ErrorCode::OutOfMemory);
  }
}

TEST_CASE("meshes that cannot be adapted are refused", "[adapt]") {
  Mesh cube = test::make_unit_cube(2, true);
  const auto refused = [&] { return refusal(cube, test::uniform_metric(cube, 0.5)); };
  SECTION("without triangles") {
    cube.tri_to_vert.clear(), cube.tri_to_entity.clear();
    const Diagnostic error = refused();
    CHECK(error.code == ErrorCode::InputUnsuitable);
    CHECK(error.point);
  }
  SECTION("without the name of one face") {
    cube.tri_to_entity[3] = kNone;
    CHECK(refused().code == ErrorCode::InputUnsuitable);
  }
  SECTION("with a triangle missing") {
    cube.tri_to_vert.pop_back(), cube.tri_to_entity.pop_back();
    CHECK(refused().code == ErrorCode::InputUnsuitable);
  }
  SECTION("with a triangle that no tet has") {
    cube.tri_to_vert.push_back({0, 1, 26}), cube.tri_to_entity.push_back(0);
    CHECK(refused().code == ErrorCode::InputUnsuitable);
  }
  SECTION("with a tet twice") {
    cube.tet_to_vert.push_back(cube.tet_to_vert[0]), cube.tet_to_entity.push_back(0);
    CHECK(refused().code == ErrorCode::InputUnsuitable);
  }
  SECTION("with a flat tet") {
    cube.tet_to_vert[5] = {0, 1, 2, 1};
    CHECK(refused().code == ErrorCode::InputUnsuitable);
  }
  SECTION("with a point that is not there") {
    cube.tet_to_vert[5][2] = 4711;
    CHECK(refused().code == ErrorCode::InvalidArgument);
  }
  SECTION("with arrays of different lengths") {
    cube.tet_to_entity.pop_back();
    CHECK(refused().code == ErrorCode::InvalidArgument);
  }
  SECTION("with a point at infinity") {
    const adapt::MetricField metric = test::uniform_metric(cube, 0.5);
    cube.points[3].y = HUGE_VAL;
    CHECK(refusal(cube, metric).code == ErrorCode::InputUnsuitable);
  }
  SECTION("empty") {
    cube = Mesh();
    CHECK(refused().code == ErrorCode::InputUnsuitable);
  }
  SECTION("with other cells") {
    cube = test::make_mixed_box(4, 4, 4);
    CHECK(refused().code == ErrorCode::InputUnsuitable);
  }
}

TEST_CASE("tags of entities that adaptation cannot tell apart are refused with the element", "[adapt]") {
  // Two bits of 32 tell the dimension.
  const std::uint32_t largest = std::uint32_t{1} << 28;
  for (const std::uint32_t index : {largest, std::uint32_t{1} << 30, 0xfffffffeu}) {
    CAPTURE(index);
    const auto refused = [&](const std::function<void(Mesh&)>& change) {
      Mesh cube = test::make_unit_cube(2);
      for (auto& table : cube.entities) table.clear();
      cube.face_to_sides.clear();
      change(cube);
      const Diagnostic error = refusal(cube, test::uniform_metric(cube, 0.4));
      CHECK(error.code == ErrorCode::InputUnsuitable);
      CHECK_THAT(error.message, Catch::Contains(std::to_string(std::uint64_t{index} + 1)));
      CHECK(error.elements.size() == 1);
    };
    refused([&](Mesh& cube) { cube.tet_to_entity[3] = index; });
    refused([&](Mesh& cube) { cube.tri_to_entity[2] = index; });
    refused([&](Mesh& cube) { cube.edge_to_entity[1] = index; });
    refused([&](Mesh& cube) { cube.point_to_entity[0] = ModelEntity(0, index); });
  }
  Mesh cube = test::make_unit_cube(2);
  for (std::uint32_t& region : cube.tet_to_entity) region = largest - 1;
  for (ModelEntity& entity : cube.point_to_entity)
    if (entity.dim == 3) entity.index = largest - 1;
  cube.face_to_sides.clear(), cube.entities = {};
  const AdaptResult result = adapted(cube, test::uniform_metric(cube, 0.2));
  CHECK(validate_mesh(result.mesh).valid());
  for (const std::uint32_t region : result.mesh.tet_to_entity) REQUIRE(region == largest - 1);
}

TEST_CASE("tags of edges and corners behind the mesh's own tables are refused, however large", "[adapt]") {
  for (const std::uint32_t index : {12u, (1u << 28) - 1}) {
    Mesh cube = test::make_unit_cube(2);
    cube.entities[1].resize(12);
    for (std::uint32_t& edge : cube.edge_to_entity) edge = edge == 3 ? index : edge;
    const Diagnostic error = refusal(cube, test::uniform_metric(cube, 0.4));
    CHECK(error.code == ErrorCode::InputUnsuitable);
    CHECK_THAT(error.message, Catch::Contains("table"));
  }
}

TEST_CASE("a mesh may have points that nothing uses, and no names of points", "[adapt]") {
  Mesh cube = test::make_unit_cube(3);
  const Mesh whole = cube;
  cube.points.push_back({5, 5, 5}), cube.point_to_entity.emplace_back();
  const AdaptResult unused = adapted(cube, test::uniform_metric(cube, 0.2));
  check_kept(whole, unused.mesh);
  cube = whole;
  cube.point_to_entity.clear();
  const AdaptResult unnamed = adapted(cube, test::uniform_metric(cube, 0.2));
  CHECK(validate_mesh(unnamed.mesh).valid());
}

TEST_CASE("the mesh of one tet, and one that has no edges named", "[adapt]") {
  Mesh mesh;
  mesh.points = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  mesh.tet_to_vert = {{0, 1, 2, 3}};
  mesh.tet_to_entity = {0};
  mesh.tri_to_vert = {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {0, 3, 2}};
  mesh.tri_to_entity = {0, 1, 2, 3};
  const AdaptResult result = adapted(mesh, test::uniform_metric(mesh, 0.12));
  CHECK(validate_mesh(result.mesh).valid());
  CHECK(result.report.after.unit > 0.9);
  double volume = 0;
  for (const auto& [entity, extent] : extents(result.mesh)) volume += entity.dim == 3 ? extent : 0;
  CHECK(volume == Approx(1.0 / 6).epsilon(1e-12));
}

TEST_CASE("edges and corners that a mesh with names does not name get a place in its tables", "[adapt]") {
  Mesh cube = test::make_unit_cube(3);
  cube.edge_to_vert.clear(), cube.edge_to_entity.clear();
  for (ModelEntity& entity : cube.point_to_entity)
    if (entity.dim < 2) entity = ModelEntity();
  cube.entities[1].resize(2), cube.entities[2].resize(6), cube.entities[3].resize(1);
  cube.entities[0].resize(1), cube.entities[2][4].name = "top";
  const AdaptResult result = adapted(cube, test::uniform_metric(cube, 0.2));
  const ValidationReport validation = validate_mesh(result.mesh);
  for (const MeshProblem& problem : validation.problems) FAIL_CHECK(problem.message);
  CHECK(result.mesh.entities[0].size() == 9);
  CHECK(result.mesh.entities[1].size() == 14);
  CHECK(result.mesh.entities[2][4].name == "top");
}

TEST_CASE("cancelled at any moment, the mesh that went in is as it was", "[adapt]") {
  const Mesh cube = test::make_unit_cube(5);
  const Mesh copy = cube;
  const adapt::MetricField metric = test::uniform_metric(cube, 0.1);
  AdaptOptions options;
  options.threads = 2, options.tets_per_part = 3000;
  std::atomic<int> looks{0};
  Host host;
  host.wants_stop = [&] { return ++looks < 0; };
  REQUIRE(adapt_mesh(cube, metric, options, host).status == AdaptStatus::Ok);
  const int all = looks;
  REQUIRE(all > 100);
  std::mt19937 random(5);
  for (int i = 0; i < 12; ++i) {
    const int last = i == 0 ? 0 : static_cast<int>(random() % static_cast<unsigned>(all * 9 / 10));
    CAPTURE(last, all);
    looks = 0;
    host.wants_stop = [&] { return ++looks > last; };
    const AdaptResult result = adapt_mesh(cube, metric, options, host);
    CHECK(result.status == AdaptStatus::Cancelled);
    CHECK(result.mesh.points.empty());
    REQUIRE(result.errors.size() == 1);
    CHECK(result.errors[0].code == ErrorCode::Cancelled);
    CHECK(cube.points == copy.points);
    CHECK(cube.tet_to_vert == copy.tet_to_vert);
    CHECK(mesh_digest(cube) == mesh_digest(copy));
  }
}

TEST_CASE("a trace has every part of every round, and changes nothing", "[adapt]") {
  const Mesh cube = test::make_unit_cube(6);
  AdaptOptions options;
  options.tets_per_part = 2000, options.threads = 2;
  const auto metric = test::uniform_metric(cube, 0.1);
  const AdaptResult plain = adapted(cube, metric, options);
  Trace trace;
  options.trace = &trace;
  const AdaptResult traced = adapted(cube, metric, options);
  CHECK(mesh_digest(traced.mesh) == mesh_digest(plain.mesh));
  const auto records = trace.records();
  const auto steps = std::count_if(records.begin(), records.end(),
                                   [](const TaskRecord& record) { return record.kind == TaskKind::Step; });
  CHECK(static_cast<std::size_t>(steps) >= traced.report.rounds);
  std::size_t most = 0;
  for (const TaskRecord& record : records)
    most = std::max<std::size_t>(most, record.part.valid() ? record.part.value + 1 : 0);
  CHECK(most == traced.report.most_parts);
  const AdaptSeconds& s = traced.report.stages;
  for (const double seconds : {s.set_up, s.metric, s.dealing, s.parts, s.result}) CHECK(seconds > 0);
  CHECK(s.set_up + s.metric + s.dealing + s.parts + s.result <= traced.report.seconds);
}

TEST_CASE("the host hears of rounds", "[adapt]") {
  const Mesh cube = test::make_unit_cube(4);
  std::vector<ProgressEvent> events;
  Host host;
  host.progress = [&](const ProgressEvent& event) {
    events.push_back(event);
    return true;
  };
  const AdaptResult result = adapt_mesh(cube, test::uniform_metric(cube, 0.1), {}, host);
  REQUIRE(result.status == AdaptStatus::Ok);
  REQUIRE_FALSE(events.empty());
  for (std::size_t i = 0; i < events.size(); ++i) {
    CHECK(events[i].stage == Stage::Adapt);
    CHECK(events[i].done <= result.report.rounds);
    if (i > 0) CHECK(events[i].done >= events[i - 1].done);
  }
  CHECK(events.back().done > 0);
}
