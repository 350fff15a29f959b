// Ranks that adapt a mesh together: the mesh of one process.
#include <catch2/catch.hpp>
#include <memory>
#include <new>
#include <random>

#include "adapt/input_checks.hpp"
#include "adapt/metric/tet_links.hpp"
#include "core/base/first_number.hpp"
#include "tests/adapt/meshed.hpp"
#include "tests/adapt/on_ranks.hpp"
#include "tests/adapt/touching_blocks.hpp"
#include "tests/adapt/uniform_metric.hpp"
#include "tests/support/analytic_model.hpp"
#include "tests/support/error_of.hpp"
#include "tests/support/sanitized.hpp"
#include "tetloom/adapt.hpp"
#include "tetloom/check.hpp"
#include "tetloom/partition.hpp"
#include "tetloom/tasks.hpp"
#include "threading/comm/simulated_ranks.hpp"

using namespace tetloom;
using adapt::Tensor;
using test::in_parts, test::layered, test::Metric, test::on_ranks;

namespace {

void check_same(const Mesh& one, const Mesh& other) {
  CHECK(one.points == other.points);
  CHECK(one.point_to_entity == other.point_to_entity);
  CHECK(one.edge_to_vert == other.edge_to_vert);
  CHECK(one.edge_to_entity == other.edge_to_entity);
  CHECK(one.tri_to_vert == other.tri_to_vert);
  CHECK(one.tri_to_entity == other.tri_to_entity);
  CHECK(one.tet_to_vert == other.tet_to_vert);
  CHECK(one.tet_to_entity == other.tet_to_entity);
  REQUIRE(one.cell_fields.size() == other.cell_fields.size());
  for (std::size_t i = 0; i < one.cell_fields.size(); ++i)
    CHECK(one.cell_fields[i].values == other.cell_fields[i].values);
  REQUIRE(one.point_fields.size() == other.point_fields.size());
  for (std::size_t i = 0; i < one.point_fields.size(); ++i)
    CHECK(one.point_fields[i].values == other.point_fields[i].values);
}

void check_same(const AdaptResult& one, const AdaptResult& other) {
  for (const Diagnostic& error : other.errors) FAIL_CHECK(error.message);
  REQUIRE(other.status == AdaptStatus::Ok);
  CHECK(one.report.rounds == other.report.rounds);
  CHECK(one.report.most_parts == other.report.most_parts);
  CHECK(one.report.operations.splits == other.report.operations.splits);
  CHECK(one.report.operations.moves == other.report.operations.moves);
  CHECK(one.report.after.edges == other.report.after.edges);
  CHECK(one.report.after.unit == other.report.after.unit);
  CHECK(one.report.after.mean_quality == other.report.after.mean_quality);
  REQUIRE(one.report.transfers.size() == other.report.transfers.size());
  for (std::size_t i = 0; i < one.report.transfers.size(); ++i) {
    const adapt::FieldTransfer &field = one.report.transfers[i], &told = other.report.transfers[i];
    CHECK(field.name == told.name);
    CHECK(field.on_cells == told.on_cells);
    REQUIRE(field.components.size() == told.components.size());
    for (std::size_t c = 0; c < field.components.size(); ++c) {
      CHECK(field.components[c].before.integral == told.components[c].before.integral);
      CHECK(field.components[c].after.integral == told.components[c].after.integral);
      CHECK(field.components[c].after.greatest == told.components[c].after.greatest);
    }
  }
}

/// The mesh and the report of one process, on each of these numbers of ranks.
AdaptResult check_like_one_process(const Mesh& mesh, const Metric& metric, AdaptOptions options,
                                   std::initializer_list<int> rank_counts = {2, 3}) {
  AdaptResult alone = adapt_mesh(mesh, metric, options);
  for (const Diagnostic& error : alone.errors) FAIL_CHECK(error.message);
  REQUIRE(alone.status == AdaptStatus::Ok);
  for (const int ranks : rank_counts) {
    CAPTURE(ranks);
    options.threads = ranks == 2 ? 2 : 1;
    const auto results = on_ranks(ranks, mesh, metric, options);
    for (const AdaptResult& result : results) check_same(alone, result);
    check_same(alone.mesh, results[0].mesh);
    for (std::size_t rank = 1; rank < results.size(); ++rank) CHECK(results[rank].mesh.points.empty());
  }
  return alone;
}

/// The same of a metric at points, on 1, 2, 3 and 5 ranks of one thread or two.
void check_field_like_one_process(const Mesh& mesh, const adapt::MetricField& metric, AdaptOptions options) {
  const AdaptResult alone = adapt_mesh(mesh, metric, options);
  REQUIRE(alone.status == AdaptStatus::Ok);
  CHECK(alone.report.most_parts > 1);
  for (const int ranks : test::kSanitized ? std::vector{3, 5} : std::vector{1, 2, 3, 5}) {
    CAPTURE(ranks);
    options.threads = ranks == 3 ? 2 : 1;
    std::vector<AdaptResult> results(static_cast<std::size_t>(ranks));
    on_simulated_ranks(ranks, [&](Communicator& communicator) {
      results[static_cast<std::size_t>(communicator.rank())] = adapt_mesh_on_ranks(mesh, metric, options, communicator);
    });
    for (const AdaptResult& result : results) check_same(alone, result);
    check_same(alone.mesh, results[0].mesh);
  }
}

/// Adds the vertices of all elements of a part.
void add_verts(const PartMesh& part, std::vector<std::uint32_t>& verts) {
  const auto add = [&](const GrowingArray<std::uint32_t>& more) {
    verts.insert(verts.end(), more.begin(), more.end());
  };
  add(part.block(CellKind::Tet).to_vert);
  for (const BoundaryBlock& block : part.boundary) add(block.to_vert);
}

}  // namespace

TEST_CASE("the mesh that ranks adapt together is that of one process", "[adapt][ranks]") {
  const auto sizes = [](const Vec3& x) { return adapt::isotropic(0.05 + 0.15 * norm(x - Vec3{0.3, 0.4, 0.5})); };
  const AdaptResult result = check_like_one_process(test::make_unit_cube(6, true), sizes, in_parts(2000), {1, 2, 3, 5});
  CHECK(result.report.most_parts > 3);  // or this says little
  CHECK(validate_mesh(result.mesh).valid());
}

TEST_CASE("numbers of the whole mesh may be beyond 32 bits", "[adapt][ranks]") {
  // Cut off at 32 bits, the second would no longer ascend.
  first_number() = GENERATE(std::uint64_t{1} << 33, (std::uint64_t{1} << 32) - 50);
  const std::shared_ptr<void> back(nullptr, [](void*) { first_number() = 0; });
  const auto sizes = [](const Vec3& x) { return adapt::isotropic(0.05 + 0.15 * norm(x - Vec3{0.3, 0.4, 0.5})); };
  const AdaptResult result = check_like_one_process(test::make_unit_cube(6, true), sizes, in_parts(2000), {2, 3, 5});
  CHECK(result.report.most_parts > 3);
}

TEST_CASE("ranks follow an anisotropic metric, and carry fields over", "[adapt][ranks]") {
  Mesh cube = test::make_unit_cube(5);
  MeshField field{"heat", 1, {}}, on_cells{"load", 2, {}};
  for (const Vec3& x : cube.points) field.values.push_back(x.x * x.y + x.z);
  for (std::size_t t = 0; t < cube.tet_to_vert.size(); ++t) {
    const Vec3& x = cube.points[cube.tet_to_vert[t][0]];
    on_cells.values.insert(on_cells.values.end(), {x.x - x.z, x.y > 0.4 ? 1.0 : 0.0});
  }
  cube.point_fields = {field}, cube.cell_fields = {on_cells};
  AdaptOptions options = in_parts(1500);
  options.transfer = {"heat", "load"};
  const AdaptResult result = check_like_one_process(cube, layered, options);
  CHECK(result.report.most_parts > 3);
  CHECK(result.report.transfers.size() == 2);
  MeshField flow{"flow", 3, {}};
  for (const Vec3& x : cube.points) flow.values.insert(flow.values.end(), {x.x, x.y * x.y, std::sin(9 * x.z)});
  cube.point_fields.push_back(flow);
  options.transfer = {"flow", "heat"};  // on points alone, out of tiles
  CHECK(check_like_one_process(cube, layered, options, {2, 3, 5}).report.transfers.size() == 2);
}

TEST_CASE("random metrics, sizes of parts and numbers of ranks give the mesh of one process", "[adapt][ranks]") {
  for (unsigned seed = 1; seed <= (test::kSanitized ? 2 : 6); ++seed) {
    CAPTURE(seed);
    std::mt19937 random(seed);
    const auto uniform = [&](double lo, double hi) {
      return lo + (hi - lo) * static_cast<double>(random()) / 4294967296.0;
    };
    const Mesh cube = test::make_unit_cube(2 * static_cast<int>(1 + random() % 3), random() % 2 == 0);
    const Vec3 centre{uniform(0, 1), uniform(0, 1), uniform(0, 1)};
    const double least = uniform(0.03, 0.3), growth = uniform(0, 0.5), aspect = uniform(1, 20);
    const auto metric = [&](const Vec3& x) {
      const double h = least + growth * norm(x - centre), along = 1 / (h * h * aspect * aspect);
      return adapt::diagonal(along, along, 1 / (h * h));
    };
    const auto ranks = static_cast<int>(2 + random() % 5);
    check_like_one_process(cube, metric, in_parts(uniform(60, 2000)), {ranks});
  }
}

TEST_CASE("ranks look metrics up at points in a mesh that none of them has as a whole", "[adapt][ranks]") {
  const Mesh cube = test::make_unit_cube(11);  // 8,000 tets in 16 tiles
  // Half of it far coarser than it was, half of it finer by several stages.
  const auto sizes = [](const Vec3& x) { return adapt::isotropic(x.x < 0.5 ? 0.3 : 0.042); };
  const auto thin = [](const Vec3& x) { return adapt::diagonal(9, 9, x.x < 0.5 ? 900 : 9); };
  for (const Metric& metric : {Metric(sizes), Metric(thin)})
    check_field_like_one_process(cube, adapt::metric_from_function(metric, cube.points), in_parts(3000));
}

TEST_CASE("what is moved to a curved model is looked up at the nearest boundary of a mesh in tiles", "[adapt][ranks]") {
  const auto model = test_models::make_cylinder(0.5, 1);
  const Mesh mesh = test::meshed(*model, 0.1);
  AdaptOptions options = in_parts(2000);
  options.model = model.get();
  const auto sizes = [](const Vec3& x) { return adapt::isotropic(0.06 + 0.1 * std::abs(x.x)); };
  check_field_like_one_process(mesh, adapt::metric_from_function(sizes, mesh.points), options);
}

TEST_CASE("vertices a little beside the model are borne on ranks as by one process", "[adapt][ranks]") {
  const auto model = test_models::make_cylinder(0.5, 1);
  Mesh mesh = test::meshed(*model, 0.15);
  for (std::size_t v = 0; v < mesh.points.size(); ++v)
    if (mesh.point_to_entity[v].dim == 1) mesh.points[v].x *= 1.005, mesh.points[v].y *= 1.005;
  AdaptOptions options = in_parts(1000);
  options.model = model.get();
  const auto sizes = [](const Vec3&) { return adapt::isotropic(0.12); };
  check_field_like_one_process(mesh, adapt::metric_from_function(sizes, mesh.points), options);
}

TEST_CASE("ranks follow a model", "[adapt][ranks]") {
  const auto model = test_models::make_cylinder(0.5, 1);
  const Mesh mesh = test::meshed(*model, 0.25);
  AdaptOptions options = in_parts(1500);
  options.model = model.get();
  const auto metric = [](const Vec3& x) { return adapt::isotropic(0.1 + 0.1 * std::abs(x.x)); };
  CHECK(check_like_one_process(mesh, metric, options).report.most_parts > 2);
}

TEST_CASE("ranks carry fields on tets over within their regions", "[adapt][ranks]") {
  Mesh cube = test::make_unit_cube(6, true);
  MeshField load{"load", 2, {}};
  for (std::size_t tet = 0; tet < cube.tet_to_vert.size(); ++tet) {
    const Vec3& x = cube.points[cube.tet_to_vert[tet][0]];
    load.values.insert(load.values.end(), {cube.tet_to_entity[tet] + x.x * x.y, x.z - 0.5});
  }
  cube.cell_fields = {load};
  AdaptOptions options = in_parts(1500);
  options.transfer = {"load"};
  options.cell_reconstruction = GENERATE(adapt::CellReconstruction::Constant, adapt::CellReconstruction::Linear);
  first_number() = std::uint64_t{1} << 33;
  const std::shared_ptr<void> back(nullptr, [](void*) { first_number() = 0; });
  const AdaptResult result = check_like_one_process(cube, layered, options, {2, 3, 5});
  CHECK(result.report.most_parts > 3);
  REQUIRE(result.report.transfers.size() == 1);
  for (const adapt::FieldTransfer::Component& component : result.report.transfers[0].components)
    CHECK(component.after.integral == Approx(component.before.integral).epsilon(1e-12).margin(1e-14));
}

TEST_CASE("fields on tets are carried over where a model moves the sides of regions", "[adapt][ranks]") {
  const auto model = test_models::make_cylinder(0.5, 1);
  Mesh mesh = test::meshed(*model, 0.3);
  MeshField load{"load", 1, {}};
  for (const auto& tet : mesh.tet_to_vert) load.values.push_back(1 + mesh.points[tet[0]].x);
  mesh.cell_fields = {load};
  AdaptOptions options = in_parts(800);
  options.transfer = {"load"}, options.model = model.get();
  const auto sizes = [](const Vec3&) { return adapt::isotropic(0.09); };
  const AdaptResult result = check_like_one_process(mesh, sizes, options);
  CHECK(result.report.most_parts > 3);
  CHECK(test::volume_of(result.mesh) > 1.02 * test::volume_of(mesh));
  const auto& [before, after] = result.report.transfers.at(0).components.at(0);
  CHECK(after.integral == Approx(before.integral).epsilon(1e-12));
}

TEST_CASE("what ranks adapt is dealt to parts of equal size, the same on any number of ranks", "[adapt][ranks]") {
  Mesh cube = test::make_unit_cube(4, true);
  MeshField field{"heat", 1, {}};
  for (const Vec3& x : cube.points) field.values.push_back(x.x * x.y + x.z);
  MeshField on_cells{"load", 2, {}};
  for (const auto& tet : cube.tet_to_vert) {
    const Vec3& x = cube.points[tet[0]];
    on_cells.values.insert(on_cells.values.end(), {x.x - x.z, 1 + x.y});
  }
  cube.point_fields = {field}, cube.cell_fields = {on_cells};
  const adapt::MetricField metric = adapt::metric_from_function(layered, cube.points);
  AdaptOptions options = in_parts(1500);
  options.transfer = {"heat", "load"};
  const AdaptResult alone = adapt_mesh(cube, metric, options);
  REQUIRE(alone.status == AdaptStatus::Ok);
  const std::vector<int> numbers_of_ranks = test::kSanitized ? std::vector{1, 3} : std::vector{1, 2, 3};
  for (const int parts : {0, 3, 500}) {
    options.parts = parts;
    std::vector<std::uint32_t> first_run;  // vertices of all elements, part by part
    for (const int ranks : numbers_of_ranks) {
      CAPTURE(parts, ranks);
      Mesh gathered;
      AdaptReport report;
      bool valid = false;
      std::size_t count = 0;
      double imbalance = 1;
      std::vector<std::vector<std::uint32_t>> tets(static_cast<std::size_t>(ranks));
      on_simulated_ranks(ranks, [&](Communicator& communicator) {
        AdaptInPartsResult result = adapt_mesh_in_parts(cube, metric, options, communicator);
        if (!result.mesh) throw Error(ErrorCode::Internal, "no parts");
        const TaskRunner runner(1);
        const bool fits = validate_parts(*result.mesh, runner).valid();
        const PartsFigures figures = measure_parts(*result.mesh);
        Mesh whole = gather_mesh(*result.mesh, runner);
        auto& own = tets[static_cast<std::size_t>(communicator.rank())];
        for (const PartId part : result.mesh->local()) add_verts(result.mesh->parts.at(part).mesh, own);
        if (communicator.rank() != 0) return;
        gathered = std::move(whole), valid = fits, report = result.run.report;
        count = result.mesh->part_count(), imbalance = figures.element_imbalance;
      });
      CHECK(valid);
      CHECK(count == (parts > 0 ? static_cast<std::size_t>(parts) : alone.report.last_parts));
      if (parts < 10) CHECK(imbalance < 0.1);
      CHECK(mesh_digest(gathered) == mesh_digest(alone.mesh));
      CHECK(gathered.points == alone.mesh.points);
      REQUIRE(gathered.point_fields.size() == 1);
      CHECK(gathered.point_fields[0].values == alone.mesh.point_fields[0].values);
      CHECK(field_digest(gathered) == field_digest(alone.mesh));
      CHECK(report.after.edges == alone.report.after.edges);
      CHECK(report.after.unit == alone.report.after.unit);
      CHECK(report.after.shortest == alone.report.after.shortest);
      CHECK(report.after.quality_histogram == alone.report.after.quality_histogram);
      CHECK(report.after.mean_quality == Approx(alone.report.after.mean_quality).epsilon(1e-12));
      CHECK(report.after.complexity == Approx(alone.report.after.complexity).epsilon(1e-12));
      std::vector<std::uint32_t> all;
      for (const auto& own : tets) all.insert(all.end(), own.begin(), own.end());
      if (ranks == 1) first_run = all;
      CHECK(all == first_run);
    }
  }
  options.parts = -1;
  const auto communicator = make_thread_communicator();
  const AdaptInPartsResult refused = adapt_mesh_in_parts(cube, metric, options, *communicator);
  CHECK_FALSE(refused.mesh);
  REQUIRE(refused.run.errors.size() == 1);
  CHECK(refused.run.errors[0].code == ErrorCode::InvalidArgument);
}

TEST_CASE("a call for parts that is cancelled while they are dealt has no mesh", "[adapt][ranks]") {
  const Mesh cube = test::make_unit_cube(3);
  const auto metric = test::uniform_metric(cube, 0.2);
  std::vector<AdaptInPartsResult> results(2);
  on_simulated_ranks(2, [&](Communicator& communicator) {
    const auto rank = static_cast<std::size_t>(communicator.rank());
    Host host;
    if (rank == 1) host.progress = [](const ProgressEvent& event) { return event.stage != Stage::Partition; };
    results[rank] = adapt_mesh_in_parts(cube, metric, in_parts(800), communicator, host);
  });
  for (const AdaptInPartsResult& result : results) {
    CHECK(result.run.status == AdaptStatus::Cancelled);
    CHECK(result.run.mesh.points.empty());
    CHECK_FALSE(result.mesh);
  }
}

TEST_CASE("there may be more ranks than parts, and than tets", "[adapt][ranks]") {
  const auto metric = [](const Vec3&) { return adapt::isotropic(0.5); };
  check_like_one_process(test::make_unit_cube(2), metric, {}, {2, 7});
  Mesh tet;
  tet.points = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  tet.tet_to_vert = {{0, 1, 2, 3}};
  tet.tet_to_entity = {0};
  tet.tri_to_vert = {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {0, 3, 2}};
  tet.tri_to_entity = {0, 1, 2, 3};
  check_like_one_process(tet, metric, in_parts(20), {3});
}

TEST_CASE("points that no tet has are nowhere, on one rank as on several", "[adapt][ranks]") {
  Mesh cube = test::make_unit_cube(4);
  cube.points.push_back({50, 5, 5}), cube.point_to_entity.emplace_back();
  const auto metric = [](const Vec3&) { return adapt::isotropic(0.15); };
  const AdaptResult result = check_like_one_process(cube, metric, in_parts(800));
  for (const Vec3& x : result.mesh.points) CHECK(x.x <= 1);
}

TEST_CASE("bodies that touch in a vertex or an edge are adapted alike by ranks", "[adapt][ranks]") {
  const auto metric = [](const Vec3&) { return adapt::isotropic(test::kSanitized ? 0.15 : 0.11); };
  for (const adapt::TouchingShape& shape : adapt::kTouchingShapes) {
    CAPTURE(shape.name);
    check_like_one_process(adapt::mesh_of(shape, 2), metric, in_parts(700), {2, 3});
  }
}

TEST_CASE("bodies that touch are one mesh again in parts", "[adapt][ranks]") {
  const auto sizes = [](const Vec3&) { return adapt::isotropic(test::kSanitized ? 0.15 : 0.11); };
  for (const adapt::TouchingShape& shape : adapt::kTouchingShapes) {
    const Mesh mesh = adapt::mesh_of(shape, 2);
    const AdaptResult alone = adapt_mesh(mesh, sizes, in_parts(700));
    REQUIRE(alone.status == AdaptStatus::Ok);
    for (const int ranks : {1, 3}) {
      CAPTURE(shape.name, ranks);
      Mesh gathered;
      std::size_t edges = 0;
      bool fits = false;
      on_simulated_ranks(ranks, [&](Communicator& communicator) {
        AdaptInPartsResult result = adapt_mesh_in_parts(mesh, sizes, in_parts(700), communicator);
        if (!result.mesh) throw Error(ErrorCode::Internal, "no parts");
        const bool valid = validate_parts(*result.mesh, TaskRunner(1)).valid();
        Mesh whole = gather_mesh(*result.mesh, TaskRunner(1));
        if (communicator.rank() != 0) return;
        gathered = std::move(whole), edges = result.run.report.after.edges, fits = valid;
      });
      CHECK(fits);
      CHECK(gathered.points == alone.mesh.points);
      CHECK(mesh_digest(gathered) == mesh_digest(alone.mesh));
      CHECK(edges == alone.report.after.edges);
    }
  }
}

TEST_CASE("a mesh and a metric that are given up lead to the same mesh", "[adapt][ranks]") {
  Mesh cube = test::make_unit_cube(4, true);
  cube.cell_fields = {{"load", 1, std::vector<double>(cube.tet_to_vert.size(), 1)}};
  cube.point_fields = {{"other", 1, std::vector<double>(cube.points.size(), 1)}};
  adapt::MetricField metric = adapt::metric_from_function(layered, cube.points);
  AdaptOptions options = in_parts(1500);
  options.transfer = {GENERATE("load", "other")};  // on tets, and on points alone
  const AdaptResult kept = adapt_mesh(cube, metric, options);
  const auto alone = make_thread_communicator();
  const AdaptResult given_up = adapt_mesh_on_ranks(std::move(cube), std::move(metric), options, *alone);
  check_same(kept, given_up);
  check_same(kept.mesh, given_up.mesh);
  CHECK(given_up.mesh.face_to_sides.size() == kept.mesh.face_to_sides.size());
}

TEST_CASE("each rank needs its share of what is given and of the result", "[adapt][ranks]") {
  const double tets = 1e8;  // 13 GB, and 3.5 GB for as many that are given, or 7.5 in tiles
  adapt::AdaptLoad load{tets / adapt::expected_tets(1), tets, 0, 1, 1};
  MemoryLimits limits;
  CHECK_NOTHROW(check_load(load, limits));
  limits.machine = 8'100'000'000;
  const Diagnostic error = test::error_of([&] { check_load(load, limits); });
  CHECK(error.code == ErrorCode::OutOfMemory);
  CHECK(error.message.find("16.5 GB") != std::string::npos);
  CHECK(error.message.find("for 3 ranks") != std::string::npos);
  load.ranks = 2;
  CHECK(test::error_of([&] { check_load(load, limits); }).message.find("on each of 2 ranks") != std::string::npos);
  load.ranks = 3;
  CHECK_NOTHROW(check_load(load, limits));
  load.components = 3;  // 30 GB more
  CHECK(test::error_of([&] { check_load(load, limits); }).message.find("for 7 ranks") != std::string::npos);
  load.components = 0, load.ranks_on_machine = 3;  // of which only one could have what it needs
  CHECK(test::error_of([&] { check_load(load, limits); }).code == ErrorCode::OutOfMemory);
  load.complexity = 1e9;
  CHECK(test::error_of([&] { check_load(load, {}); }).message.find("counted") != std::string::npos);
}
