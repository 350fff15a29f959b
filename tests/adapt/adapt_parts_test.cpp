// Meshes that lie in parts, adapted where they lie: the mesh of one process that has it all.
#include <atomic>
#include <catch2/catch.hpp>
#include <memory>
#include <new>
#include <optional>
#include <utility>

#include "adapt/metric/own_tets.hpp"
#include "adapt/parts/slice_gradation.hpp"
#include "core/base/first_number.hpp"
#include "tests/adapt/meshed.hpp"
#include "tests/adapt/random_tensors.hpp"
#include "tests/adapt/touching_blocks.hpp"
#include "tests/support/analytic_model.hpp"
#include "tests/support/error_of.hpp"
#include "tests/support/mixed_mesh.hpp"
#include "tests/support/sanitized.hpp"
#include "tetloom/adapt.hpp"
#include "tetloom/check.hpp"
#include "tetloom/partition.hpp"
#include "tetloom/tasks.hpp"
#include "threading/comm/simulated_ranks.hpp"

using namespace tetloom;
using namespace tetloom::adapt;

namespace {

Tensor layered_coarsely(const Vec3& x) {
  const double h = 0.04 + 0.3 * std::abs(x.z - 0.5);
  return diagonal(30, 30, 1 / (h * h));
}

MeshField wave(const Mesh& mesh) {
  MeshField field{"wave", 2, {}};
  for (const Vec3& x : mesh.points) field.values.insert(field.values.end(), {std::sin(7 * x.x), x.y * x.z});
  return field;
}

/// `mesh` in parts over these ranks, dealt without regard to where tets lie.
PartitionedMesh in_parts(const Mesh& mesh, std::size_t parts, Communicator& ranks) {
  const TaskRunner runner(1);
  PartitionedMesh made = distribute_mesh(mesh, ranks);
  PerPart<Destinations> destinations(1, made.local());
  for (const PartId part : made.local())
    for (std::size_t tet = 0; tet < made.parts.at(part).mesh.cell_count(); ++tet)
      destinations.at(part).push_back(static_cast<std::uint32_t>(tet * 7 / 3 % parts));
  migrate(made, std::move(destinations), parts, runner);
  return made;
}

PerPart<MetricField> metric_of(const PartitionedMesh& mesh, const std::function<Tensor(const Vec3&)>& metric) {
  PerPart<MetricField> fields(mesh.part_count(), mesh.local());
  for (const PartId part : mesh.local())
    fields.at(part) = metric_from_function(metric, mesh.parts.at(part).mesh.points.span());
  return fields;
}

AdaptOptions options_for(double tets_per_part) {
  AdaptOptions options;
  options.tets_per_part = tets_per_part, options.threads = 1;
  return options;
}

/// The same mesh and figures on all these numbers of ranks.
AdaptReport check_like_whole(const Mesh& mesh, std::size_t parts, const std::function<Tensor(const Vec3&)>& metric,
                             const AdaptOptions& options, std::initializer_list<int> rank_counts = {1, 2, 5}) {
  AdaptResult first;
  for (const int ranks : rank_counts) {
    CAPTURE(ranks);
    std::vector<AdaptResult> results(static_cast<std::size_t>(ranks));
    on_simulated_ranks(ranks, [&](Communicator& communicator) {
      PartitionedMesh dealt = in_parts(mesh, parts, communicator);
      PerPart<MetricField> fields = metric_of(dealt, metric);
      results[static_cast<std::size_t>(communicator.rank())] =
          adapt_mesh_on_ranks(std::move(dealt), std::move(fields), options);
    });
    for (const AdaptResult& result : results) {
      for (const Diagnostic& error : result.errors) FAIL_CHECK(error.message);
      REQUIRE(result.status == AdaptStatus::Ok);
    }
    if (first.mesh.points.empty()) first = results[0];
    const AdaptResult& result = results[0];
    CHECK(result.mesh.points == first.mesh.points);
    CHECK(result.mesh.tet_to_vert == first.mesh.tet_to_vert);
    CHECK(result.mesh.tri_to_entity == first.mesh.tri_to_entity);
    CHECK(result.mesh.edge_to_entity == first.mesh.edge_to_entity);
    CHECK(result.mesh.point_to_entity == first.mesh.point_to_entity);
    CHECK(field_digest(result.mesh) == field_digest(first.mesh));
    CHECK(result.report.before.edges == first.report.before.edges);
    CHECK(result.report.before.complexity == first.report.before.complexity);
    CHECK(result.report.turning.followed == first.report.turning.followed);
    REQUIRE(result.report.transfers.size() == first.report.transfers.size());
    for (std::size_t i = 0; i < first.report.transfers.size(); ++i) {
      const auto& one = first.report.transfers[i].components[0].before;
      const auto& other = result.report.transfers[i].components[0].before;
      CHECK(one.integral == other.integral);
      CHECK(one.least == other.least);
    }
  }
  CHECK(first.report.most_parts > 1);
  CHECK(validate_mesh(first.mesh).valid());
  return first.report;
}

}  // namespace

TEST_CASE("a mesh in parts becomes the same mesh on any number of ranks, with its fields", "[adapt][parts]") {
  Mesh cube = test::make_unit_cube(5, true);
  cube.point_fields = {wave(cube), {"other", 1, std::vector<double>(cube.points.size(), 3)}};
  AdaptOptions options = options_for(1500);
  options.transfer = {"wave"};
  CHECK(check_like_whole(cube, 3, layered_coarsely, options, {1, 2, 3, 5}).transfers.size() == 1);
}

TEST_CASE("a mesh in parts is graded as a whole", "[adapt][parts]") {
  AdaptOptions options = options_for(1500);
  options.gradation = 1.3;
  const auto spike = [](const Vec3& x) { return isotropic(norm(x - Vec3{0.3, 0.4, 0.2}) < 0.2 ? 0.06 : 0.5); };
  check_like_whole(test::make_unit_cube(6, true), 4, spike, options);
}

TEST_CASE("metrics that turn too fast are limited alike in parts", "[adapt][parts]") {
  const auto turning = [](const Vec3& x) {
    const double angle = 9 * x.x;
    const Vec3 along{std::cos(angle), std::sin(angle), 0};
    return diagonal(9, 9, 9) + outer(along, 500);
  };
  CHECK(check_like_whole(test::make_unit_cube(6, true), 3, turning, options_for(2000), {1, 3}).turning.turns);
}

TEST_CASE("fields on tets of a mesh in parts are carried over", "[adapt][parts]") {
  Mesh cube = test::make_unit_cube(4, true);
  MeshField load{"load", 1, {}};
  for (const auto& tet : cube.tet_to_vert) load.values.push_back(cube.points[tet[0]].x);
  cube.cell_fields = {load}, cube.point_fields = {wave(cube)};
  AdaptOptions options = options_for(1500);
  options.transfer = {"load", "wave"};
  check_like_whole(cube, 3, layered_coarsely, options, {1, 3});
}

TEST_CASE("bodies that touch are adapted in parts as a whole", "[adapt][parts]") {
  for (const TouchingShape& shape : kTouchingShapes) {
    CAPTURE(shape.name);
    check_like_whole(mesh_of(shape, 2), 3, [](const Vec3&) { return isotropic(0.13); }, options_for(700), {1, 3});
  }
}

TEST_CASE("edges and corners that a mesh in parts does not name get the same names everywhere", "[adapt][parts]") {
  Mesh cube = test::make_unit_cube(4, true);
  cube.edge_to_vert.clear(), cube.edge_to_entity.clear();
  for (ModelEntity& entity : cube.point_to_entity)
    if (entity.dim < 2) entity = ModelEntity();
  for (auto& table : cube.entities) table.clear();
  check_like_whole(
      cube, 5, [](const Vec3& x) { return isotropic(0.1 + 0.1 * x.x); }, options_for(1500));
}

TEST_CASE("a mesh in parts follows a model", "[adapt][parts]") {
  const auto model = test_models::make_cylinder(0.5, 1);
  AdaptOptions options = options_for(1500);
  options.model = model.get();
  check_like_whole(test::meshed(*model, 0.2), 4, [](const Vec3& x) { return isotropic(0.1 + 0.1 * std::abs(x.x)); },
                   options, {1, 3});
}

TEST_CASE("a metric in parts becomes finer where the model is curved, as that of the whole mesh", "[adapt][parts]") {
  const std::vector<std::shared_ptr<const GeometricModel>> bodies{test_models::make_cylinder(1, 2),
                                                                  test_models::make_sphere({4, 0, 1}, 0.5)};
  const auto model = test_models::combine(bodies);
  const Mesh mesh = test::meshed(*model, 0.4);
  AdaptOptions options = options_for(500);
  options.model = model.get();
  const auto coarse = [](const Vec3&) { return isotropic(0.4); };
  const double plain = check_like_whole(mesh, 5, coarse, options, {1, 2}).before.complexity;
  options.curvature = CurvatureLimits{18, 0};
  CHECK(check_like_whole(mesh, 5, coarse, options, {1, 2, 3, 6}).before.complexity > 1.5 * plain);
  // The same as limits that are set beforehand.
  MetricField metric;
  metric.logs.assign(mesh.points.size(), log(isotropic(0.4)));
  const AdaptResult whole = adapt_mesh(mesh, metric, options);
  REQUIRE(whole.status == AdaptStatus::Ok);
  limit_by_curvature(metric, mesh, *model, *std::exchange(options.curvature, {}), TaskRunner(1));
  CHECK(mesh_digest(adapt_mesh(mesh, metric, options).mesh) == mesh_digest(whole.mesh));
}

TEST_CASE("parts are adapted from and to where they lie, also by a function", "[adapt][parts]") {
  const Mesh cube = test::make_unit_cube(5, true);
  std::vector<std::string> digests;
  for (const int ranks : {1, 3}) {
    Mesh gathered;
    on_simulated_ranks(ranks, [&](Communicator& communicator) {
      AdaptInPartsResult result =
          adapt_mesh_in_parts(in_parts(cube, 4, communicator), layered_coarsely, options_for(1500));
      if (!result.mesh) throw Error(ErrorCode::Internal, result.run.errors.at(0).message);
      Mesh whole = gather_mesh(*result.mesh, TaskRunner(1));
      if (communicator.rank() == 0) gathered = std::move(whole);
    });
    digests.push_back(mesh_digest(gathered));
  }
  CHECK(digests[0] == digests[1]);
}

namespace {

/// What all of two ranks are told that adapt a mesh in 3 parts, after `change` of what the second of them gives.
Diagnostic told_to_all(
    const Mesh& given, const std::function<void(PerPart<MetricField>&, AdaptOptions&)>& change = [](auto&, auto&) {}) {
  std::vector<AdaptResult> results(2);
  on_simulated_ranks(2, [&](Communicator& communicator) {
    PartitionedMesh mesh = in_parts(given, 3, communicator);
    PerPart<MetricField> metric = metric_of(mesh, layered_coarsely);
    AdaptOptions options = options_for(1000);
    if (communicator.rank() == 1) change(metric, options);
    results[static_cast<std::size_t>(communicator.rank())] =
        adapt_mesh_on_ranks(std::move(mesh), std::move(metric), options);
  });
  for (const AdaptResult& result : results) {
    REQUIRE(result.errors.size() == 1);
    CHECK(result.status == AdaptStatus::Failed);
    CHECK(result.errors[0].message == results[0].errors[0].message);
  }
  return results[0].errors[0];
}

}  // namespace

TEST_CASE("parts that cannot be adapted are told alike by all ranks", "[adapt][parts]") {
  using MetricInParts = PerPart<MetricField>;
  const Mesh cube = test::make_unit_cube(3, true);
  Diagnostic error = told_to_all(
      cube, [](MetricInParts& metric, AdaptOptions&) { metric.at(metric.local().front()).logs.pop_back(); });
  CHECK(error.code == ErrorCode::InvalidArgument);
  CHECK(error.message.find("points of a part") != std::string::npos);
  error = told_to_all(cube, [](MetricInParts&, AdaptOptions& options) { options.quality_floor = 0.2; });
  CHECK(error.code == ErrorCode::InvalidArgument);
  CHECK(error.message.find("not given the same") != std::string::npos);
  error = told_to_all(cube, [](MetricInParts&, AdaptOptions& options) { options.curvature = CurvatureLimits{}; });
  CHECK(error.message.find("need a model") != std::string::npos);
  const auto model = test_models::make_box({0, 0, 0}, {1, 1, 1});
  error = told_to_all(cube, [&](MetricInParts&, AdaptOptions& options) {
    options.model = model.get(), options.curvature = CurvatureLimits{-3, 0};
  });
  CHECK(error.code == ErrorCode::InvalidArgument);
  error = told_to_all(cube, [](MetricInParts&, AdaptOptions& options) { options.transfer = {"nothing"}; });
  CHECK(error.code == ErrorCode::InvalidArgument);
  CHECK(error.message.find("nothing") != std::string::npos);
}

TEST_CASE("meshes in parts that cannot be adapted are refused with a place", "[adapt][parts]") {
  Mesh unnamed = test::make_unit_cube(3, true);
  unnamed.tri_to_entity[5] = kNone;
  Diagnostic error = told_to_all(unnamed);
  CHECK(error.code == ErrorCode::InputUnsuitable);
  CHECK(error.message.find("triangle that names its model face") != std::string::npos);
  CHECK(error.point);
  Mesh flat = test::make_unit_cube(3, true);
  const auto& v = flat.tet_to_vert[7];
  flat.points[v[3]] = (1.0 / 3) * (flat.points[v[0]] + flat.points[v[1]] + flat.points[v[2]]);
  error = told_to_all(flat);
  CHECK(error.code == ErrorCode::InputUnsuitable);
  CHECK(error.point);
  Mesh endless = test::make_unit_cube(3, true);
  endless.points[9].y = HUGE_VAL;
  CHECK(told_to_all(endless).code == ErrorCode::InputUnsuitable);
  Mesh mixed = test::make_mixed_box(4, 4, 4);
  CHECK(told_to_all(mixed).message.find("only meshes of tetrahedra") != std::string::npos);
}

TEST_CASE("what one rank's metric throws ends the adaptation of parts on all", "[adapt][parts]") {
  for (const int failing : {0, 2}) {
    std::vector<AdaptResult> results(3);
    on_simulated_ranks(3, [&](Communicator& communicator) {
      const bool fails = communicator.rank() == failing;
      std::atomic<int> asked{0};
      const auto metric = [&](const Vec3& x) {
        if (fails && ++asked > 300) throw std::bad_alloc();
        return layered_coarsely(x);
      };
      results[static_cast<std::size_t>(communicator.rank())] =
          adapt_mesh_on_ranks(in_parts(test::make_unit_cube(4, true), 5, communicator), metric, options_for(800));
    });
    for (const AdaptResult& result : results) {
      REQUIRE(result.errors.size() == 1);
      CHECK(result.errors[0].code == ErrorCode::OutOfMemory);
    }
  }
}

TEST_CASE("there may be more ranks than parts and than tets of a mesh in parts", "[adapt][parts]") {
  Mesh tet;
  tet.points = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  tet.tet_to_vert = {{0, 1, 2, 3}}, tet.tet_to_entity = {0};
  tet.tri_to_vert = {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {0, 3, 2}}, tet.tri_to_entity = {0, 1, 2, 3};
  check_like_whole(tet, 1, [](const Vec3&) { return isotropic(0.2); }, options_for(20), {1, 4});
}

namespace {

/// A layer across the cube, of which second derivatives are large in one direction.
Mesh cube_with_heat(int n) {
  Mesh cube = test::make_unit_cube(n, true);
  MeshField heat{"heat", 1, {}};
  for (const Vec3& x : cube.points) heat.values.push_back(std::tanh(8 * (x.x + 0.3 * x.y - 0.6)) + 0.1 * x.z * x.z);
  cube.point_fields = {heat, wave(cube)};
  return cube;
}

SolutionMetric of_heat(double complexity, double gradation = 0) {
  SolutionMetric metric{"heat", {}};
  metric.options.complexity = complexity, metric.options.gradation = gradation;
  return metric;
}

std::vector<AdaptResult> adapt_to_solution(const Mesh& mesh, std::size_t parts, const SolutionMetric& metric,
                                           const AdaptOptions& options, int ranks) {
  std::vector<AdaptResult> results(static_cast<std::size_t>(ranks));
  on_simulated_ranks(ranks, [&](Communicator& communicator) {
    results[static_cast<std::size_t>(communicator.rank())] =
        adapt_mesh_on_ranks(in_parts(mesh, parts, communicator), metric, options);
  });
  return results;
}

/// What all ranks say that are given this.
Diagnostic told_of_solution(const Mesh& mesh, const SolutionMetric& metric, const AdaptOptions& options = {}) {
  const auto results = adapt_to_solution(mesh, 4, metric, options, 3);
  for (const AdaptResult& result : results) {
    REQUIRE(result.errors.size() == 1);
    CHECK(result.errors[0].message == results[0].errors[0].message);
  }
  return results[0].errors[0];
}

}  // namespace

TEST_CASE("the metric of a solution in parts is that of the whole mesh", "[adapt][parts]") {
  const Mesh cube = cube_with_heat(6);
  AdaptOptions options = options_for(1500);
  options.transfer = {"wave"};
  for (const double gradation : {0.0, 1.4}) {
    options.gradation = gradation;
    const SolutionMetric metric = of_heat(600, gradation);
    const HessianMetric whole =
        metric_from_solution(cube.point_fields[0].values, {cube.points, cube.tet_to_vert}, metric.options);
    AdaptResult first;
    for (const int ranks : test::kSanitized ? std::vector{1, 3, 8} : std::vector{1, 2, 3, 5, 8}) {
      CAPTURE(ranks, gradation);
      std::vector<AdaptResult> results = adapt_to_solution(cube, 4, metric, options, ranks);
      for (const AdaptResult& result : results) {
        for (const Diagnostic& error : result.errors) FAIL_CHECK(error.message);
        REQUIRE(result.status == AdaptStatus::Ok);
      }
      if (ranks == 1) first = results[0];
      CHECK(results[0].report.before.complexity == first.report.before.complexity);
      CHECK(results[0].report.before.complexity == Approx(whole.complexity).epsilon(0.01));
      CHECK(results[0].mesh.points == first.mesh.points);
      CHECK(results[0].mesh.tet_to_vert == first.mesh.tet_to_vert);
      CHECK(field_digest(results[0].mesh) == field_digest(first.mesh));
      CHECK(results[0].mesh.point_fields.size() == 1);
    }
    CHECK(first.report.most_parts > 1);
  }
}

TEST_CASE("a slab of one layer has the same second derivatives in parts", "[adapt][parts]") {
  // Two rings of vertices do not determine a polynomial there.
  test::BoxSpec spec{8, 8, 1, false, 1};
  spec.h = 0.125;
  Mesh slab = test::make_tet_box(spec);
  MeshField heat{"heat", 1, {}};
  for (const Vec3& x : slab.points) heat.values.push_back(std::tanh(9 * (x.x - 0.4)));
  slab.point_fields = {heat};
  std::optional<std::string> digest;
  for (const int ranks : {1, 2, 3, 6}) {
    const auto results = adapt_to_solution(slab, 5, of_heat(300), options_for(800), ranks);
    REQUIRE(results[0].status == AdaptStatus::Ok);
    if (!digest) digest = mesh_digest(results[0].mesh);
    CHECK(mesh_digest(results[0].mesh) == *digest);
  }
  first_number() = std::uint64_t{1} << 33;
  const std::shared_ptr<void> back(nullptr, [](void*) { first_number() = 0; });
  CHECK(mesh_digest(adapt_to_solution(slab, 5, of_heat(300), options_for(800), 3)[0].mesh) == *digest);
}

TEST_CASE("solutions that make no metric are told alike by all ranks", "[adapt][parts]") {
  const Mesh cube = cube_with_heat(3);
  SolutionMetric missing = of_heat(100), vector = of_heat(100);
  missing.field = "cold", vector.field = "wave";
  CHECK(told_of_solution(cube, missing).message.find("no field \"cold\"") != std::string::npos);
  CHECK(told_of_solution(cube, vector).message.find("one component") != std::string::npos);
  CHECK(told_of_solution(cube, of_heat(-1)).code == ErrorCode::InvalidArgument);
  CHECK(told_of_solution(cube, of_heat(100, 0.5)).code == ErrorCode::InvalidArgument);
  Mesh constant = cube, endless = cube;
  std::ranges::fill(constant.point_fields[0].values, 7.0);
  CHECK(told_of_solution(constant, of_heat(100)).message.find("no curvature") != std::string::npos);
  endless.point_fields[0].values[11] = NAN;
  const Diagnostic error = told_of_solution(endless, of_heat(100));
  CHECK(error.code == ErrorCode::InputUnsuitable);
  CHECK(error.point);
  std::vector<AdaptResult> results(2);
  Mesh loaded = cube;
  loaded.cell_fields = {{"load", 1, std::vector<double>(cube.tet_to_vert.size(), 1)}};
  loaded.cell_fields[0].values[5] = NAN;
  AdaptOptions carried = options_for(800);
  carried.transfer = {"load"};
  on_simulated_ranks(2, [&](Communicator& communicator) {
    results[static_cast<std::size_t>(communicator.rank())] =
        adapt_mesh_on_ranks(in_parts(loaded, 4, communicator), of_heat(100), carried);
  });
  for (const AdaptResult& result : results) {
    REQUIRE(result.errors.size() == 1);
    CHECK(result.errors[0].message.find("not finite") != std::string::npos);
    CHECK(result.errors[0].point);
    CHECK(result.errors[0].elements.empty());
  }
  on_simulated_ranks(2, [&](Communicator& communicator) {
    const int rank = communicator.rank();
    results[static_cast<std::size_t>(rank)] =
        adapt_mesh_on_ranks(in_parts(cube, 4, communicator), of_heat(100 + rank), {});
  });
  for (const AdaptResult& result : results) {
    REQUIRE(result.errors.size() == 1);
    CHECK(result.errors[0].message.find("not given the same") != std::string::npos);
  }
}
