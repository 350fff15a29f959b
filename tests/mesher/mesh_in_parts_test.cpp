// A mesh that is made in parts is the mesh that is made in one piece.
#include "tetloom/mesh.hpp"
#include "tetloom/tasks.hpp"

#include <catch2/catch.hpp>

#include "core/base/first_number.hpp"
#include "tests/support/analytic_model.hpp"
#include "tests/threading/communicators.hpp"
#include "tetloom/check.hpp"
#include "tetloom/partition.hpp"

using namespace tetloom;
using namespace tetloom::test_models;

namespace {

MeshOptions options_in_parts(double size, double tets_per_part = 0) {
  MeshOptions options;
  options.sizes.size = size;
  options.threads = 2;
  options.tets_per_part = tets_per_part;
  return options;
}

std::unique_ptr<GeometricModel> two_bodies() {
  std::vector<std::shared_ptr<const GeometricModel>> bodies{make_box({0, 0, 0}, {1, 1, 1}), make_torus(3, 0.6)};
  return combine(bodies);
}

/// The first rank has the mesh of make_mesh, element for element; the others have its surface.
void check_on_ranks(const GeometricModel& model, const MeshOptions& options) {
  const auto communicator = make_communicator();
  const MeshResult ranks = make_mesh_on_ranks(model, options, *communicator);
  const MeshResult whole = make_mesh(model, options);
  REQUIRE(whole.status == MeshStatus::Ok);
  REQUIRE(ranks.status == MeshStatus::Ok);
  CHECK(ranks.filling.optimizer.edges_removed == whole.filling.optimizer.edges_removed);
  CHECK(ranks.filling.core_tets == whole.filling.core_tets);
  CHECK(ranks.model_volume == whole.model_volume);
  if (communicator->rank() != 0) {
    CHECK(ranks.mesh.tet_to_vert.empty());
    CHECK(ranks.mesh.tri_to_entity == whole.mesh.tri_to_entity);
    return;
  }
  CHECK(ranks.mesh.points == whole.mesh.points);
  CHECK(ranks.mesh.point_to_entity == whole.mesh.point_to_entity);
  CHECK(ranks.mesh.edge_to_vert == whole.mesh.edge_to_vert);
  CHECK(ranks.mesh.tri_to_vert == whole.mesh.tri_to_vert);
  CHECK(ranks.mesh.tet_to_vert == whole.mesh.tet_to_vert);
  CHECK(ranks.mesh.tet_to_entity == whole.mesh.tet_to_entity);
}

/// The parts fit together, and are the mesh of make_mesh.
void check_same(const GeometricModel& model, const MeshOptions& options, std::size_t least_parts,
                std::size_t most_parts) {
  const auto communicator = make_communicator();
  MeshInPartsResult parts = make_mesh_in_parts(model, options, *communicator);
  REQUIRE(parts.run.status == MeshStatus::Ok);
  REQUIRE(parts.mesh);
  CHECK(parts.mesh->part_count() >= least_parts);
  CHECK(parts.mesh->part_count() <= most_parts);
  std::uint64_t highest = first_number();
  for (const PartId part : parts.mesh->local())
    for (const std::uint64_t number : parts.mesh->parts.at(part).mesh.vert_to_global)
      highest = std::max(highest, number);
  CHECK((parts.mesh->local().empty() || highest > first_number()));
  const TaskRunner runner(options.threads);
  const PartsReport report = validate_parts(*parts.mesh, runner);
  for (const PartProblem& problem : report.problems) UNSCOPED_INFO(problem.message);
  CHECK(report.valid());
  const Mesh gathered = gather_mesh(*parts.mesh, runner);
  const MeshResult whole = make_mesh(model, options);
  REQUIRE(whole.status == MeshStatus::Ok);
  CHECK(parts.run.filling.optimizer.edges_swapped == whole.filling.optimizer.edges_swapped);
  CHECK(parts.run.filling.optimizer.vertices_slid == whole.filling.optimizer.vertices_slid);
  CHECK(parts.run.filling.parts.parts == whole.filling.parts.parts);
  if (communicator->rank() != 0) return;
  CHECK(mesh_digest(gathered) == mesh_digest(whole.mesh));
  CHECK(gathered.points == whole.mesh.points);  // global ids are the numbers of make_mesh
  CHECK(gathered.face_to_sides.size() == whole.mesh.face_to_sides.size());
  for (const std::size_t dim : {2, 3}) CHECK(gathered.entities[dim].size() == whole.mesh.entities[dim].size());
}

}  // namespace

TEST_CASE("the parts in which a volume was filled are the mesh of one piece") {
  check_same(*make_box({0, 0, 0}, {1, 1, 1}), options_in_parts(0.07, 4000), 3, 10);
  check_same(*make_sphere({0, 0, 0}, 1), options_in_parts(0.13, 4000), 3, 10);
}

TEST_CASE("points of the whole mesh may have numbers beyond 32 bits") {
  // Cut off at 32 bits, the second would no longer ascend.
  first_number() = GENERATE(std::uint64_t{1} << 33, (std::uint64_t{1} << 32) - 5000);
  const std::shared_ptr<void> back(nullptr, [](void*) { first_number() = 0; });
  check_same(*make_torus(3, 0.6), options_in_parts(0.12, 4000), 3, 80);
  check_on_ranks(*make_torus(3, 0.6), options_in_parts(0.12, 4000));
  MeshOptions options = options_in_parts(0.14, 8000);
  options.parts = 7;
  check_same(*two_bodies(), options, 7, 7);
}

TEST_CASE("ranks make the mesh of one process") {
  check_on_ranks(*make_box({0, 0, 0}, {1, 1, 1}), options_in_parts(0.07, 4000));
  check_on_ranks(*make_box({0, 0, 0}, {1, 1, 1}), options_in_parts(0.3));
  check_on_ranks(*two_bodies(), options_in_parts(0.14, 8000));
  check_on_ranks(*two_bodies(), options_in_parts(0.25));
}

TEST_CASE("ranks mesh what no solid has, too") {
  check_on_ranks(*make_plate(2, 1), options_in_parts(0.2));
  std::vector<std::shared_ptr<const GeometricModel>> bodies{make_box({0, 0, 0}, {1, 1, 1}), make_plate(2, 1)};
  check_on_ranks(*combine(bodies), options_in_parts(0.2));
  MeshOptions options = options_in_parts(0.2);
  options.surface_only = true;
  check_on_ranks(*make_box({0, 0, 0}, {1, 1, 1}), options);
}

TEST_CASE("what memory cannot hold, and options that are none, end alike on all ranks") {
  const auto communicator = make_communicator();
  MeshOptions options = options_in_parts(0.05, 4000);
  options.max_memory = 1 << 20;
  const MeshResult result = make_mesh_on_ranks(*make_box({0, 0, 0}, {1, 1, 1}), options, *communicator);
  CHECK(result.status == MeshStatus::Failed);
  CHECK(result.mesh.tet_to_vert.empty());
  REQUIRE(result.errors.size() == 1);
  CHECK(result.errors[0].code == ErrorCode::OutOfMemory);
  options.threads = -1;
  CHECK_THROWS_AS(make_mesh_on_ranks(*make_box({0, 0, 0}, {1, 1, 1}), options, *communicator), Error);
}

TEST_CASE("what becomes of the surface while volumes are filled is in their parts") {
  MeshOptions options = options_in_parts(0.12, 3000);
  options.sizes.curvature = 20;
  options.sizes.gradation = 0.7;
  options.goals.dihedral = 35;
  options.goals.mean_ratio = 0.8;
  const auto model = make_torus(1, 0.35);
  const MeshResult whole = make_mesh(*model, options);
  REQUIRE(whole.filling.parts.parts >= 2);  // or this test says nothing; as the next two
  REQUIRE(whole.filling.optimizer.vertices_slid > 0);
  REQUIRE(whole.filling.optimizer.edges_swapped > 0);
  check_same(*model, options, 2, 40);
  check_on_ranks(*model, options);
}

TEST_CASE("complexes that are filled in one part are a part each") {
  check_same(*two_bodies(), options_in_parts(0.25), 2, 2);
  check_same(*make_box({0, 0, 0}, {1, 1, 1}), options_in_parts(0.3), 1, 1);
}

TEST_CASE("some complexes in parts and others whole") {
  check_same(*two_bodies(), options_in_parts(0.14, 8000), 3, 40);
}

TEST_CASE("the mesh is dealt to as many parts as are asked for, also to more than it has tets") {
  for (const int parts : {1, 3, 2000}) {
    CAPTURE(parts);
    MeshOptions options = options_in_parts(parts > 3 ? 0.4 : 0.09, 4000);
    options.parts = parts;
    check_same(*make_box({0, 0, 0}, {1, 1, 1}), options, static_cast<std::size_t>(parts),
               static_cast<std::size_t>(parts));
  }
  MeshOptions options = options_in_parts(0.09, 4000);
  options.parts = 3;
  const auto communicator = make_communicator();
  const MeshInPartsResult result = make_mesh_in_parts(*make_box({0, 0, 0}, {1, 1, 1}), options, *communicator);
  CHECK(measure_parts(*result.mesh).element_imbalance < 0.05);
}

TEST_CASE("the parts do not depend on the number of threads") {
  const auto model = two_bodies();
  std::vector<std::string> digests;
  for (const int threads : {1, 2, 4}) {
    MeshOptions options = options_in_parts(0.14, 8000);
    options.threads = threads;
    const auto communicator = make_communicator();
    const MeshInPartsResult result = make_mesh_in_parts(*model, options, *communicator);
    REQUIRE(result.mesh);
    MessageWriter tets;
    for (const PartId part : result.mesh->local())
      tets.put_array<std::uint32_t>(result.mesh->parts.at(part).mesh.block(CellKind::Tet).to_vert.span());
    const Bytes bytes = tets.take();
    digests.emplace_back(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  }
  CHECK(digests[0] == digests[1]);
  CHECK(digests[0] == digests[2]);
}

TEST_CASE("models that cannot be dealt to parts are refused before any work") {
  const auto communicator = make_communicator();
  const auto refused = [&](const GeometricModel& model, std::size_t entities) {
    const MeshInPartsResult result = make_mesh_in_parts(model, options_in_parts(0.2), *communicator);
    CHECK(result.run.status == MeshStatus::Failed);
    CHECK_FALSE(result.mesh);
    CHECK(result.run.mesh.points.empty());
    REQUIRE(result.run.errors.size() == 1);
    CHECK(result.run.errors[0].code == ErrorCode::InputUnsuitable);
    CHECK(result.run.errors[0].entities.size() == entities);
  };
  std::vector<std::shared_ptr<const GeometricModel>> bodies{make_box({0, 0, 0}, {1, 1, 1}), make_plate(2, 1)};
  refused(*combine(bodies), 1);
  refused(*make_plate(2, 1), 0);
}

TEST_CASE("parts of a surface alone, and fewer parts than none, are no options") {
  const auto communicator = make_communicator();
  const auto model = make_box({0, 0, 0}, {1, 1, 1});
  const auto code_of = [&](const MeshOptions& options) {
    try {
      make_mesh_in_parts(*model, options, *communicator);
    } catch (const Error& error) {
      return error.code();
    }
    return ErrorCode::Internal;
  };
  MeshOptions options = options_in_parts(0.3);
  options.surface_only = true;
  CHECK(code_of(options) == ErrorCode::InvalidArgument);
  options = options_in_parts(0.3);
  options.parts = -1;
  CHECK(code_of(options) == ErrorCode::InvalidArgument);
}

TEST_CASE("a call for parts is cancelled at any stage, and has no mesh then") {
  const auto model = make_box({0, 0, 0}, {1, 1, 1});
  for (const Stage stage : {Stage::Faces, Stage::Volume, Stage::Partition}) {
    Host host;
    host.progress = [&](const ProgressEvent& event) { return event.stage != stage; };
    MeshOptions options = options_in_parts(0.07, 4000);
    options.parts = 5;
    const auto communicator = make_communicator();
    const MeshInPartsResult result = make_mesh_in_parts(*model, options, *communicator, host);
    CHECK(result.run.status == MeshStatus::Cancelled);
    CHECK_FALSE(result.mesh);
  }
}
