// Boundary layers of meshes that are made in parts, and by ranks: the mesh of one piece, every stack in one part.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <map>
#include <numbers>
#include <set>

#include "core/base/first_number.hpp"
#include "tests/support/analytic_model.hpp"
#include "tests/threading/communicators.hpp"
#include "tests/threading/part_cases.hpp"
#include "tetloom/check.hpp"
#include "tetloom/mesh.hpp"
#include "tetloom/partition.hpp"
#include "tetloom/tasks.hpp"

using namespace tetloom;
using namespace tetloom::test_models;

namespace {

// Layers on every face that is not among the last `but`.
MeshOptions with_layers(const GeometricModel& model, double size, std::size_t but = 0) {
  MeshOptions options;
  options.sizes.size = size;
  options.threads = 2;
  for (std::uint32_t f = 0; f + but < model.topology().face_count(); ++f) {
    WallLayers wall;
    wall.face = ModelFaceId(f);
    wall.first_height = size / 20;
    wall.count = 6;
    options.layers.walls.push_back(wall);
  }
  return options;
}

std::unique_ptr<GeometricModel> ball_in_box() {
  std::vector<std::shared_ptr<const GeometricModel>> bodies{make_box({0, 0, 0}, {2, 2, 2}), make_sphere({5, 0, 0}, 1)};
  return combine(bodies);
}

// How many cells each part of this rank has of every stack.
std::map<double, std::size_t> stacks_of(const PartMesh& part) {
  std::map<double, std::size_t> stacks;
  for (const CellField& field : part.cell_fields)
    if (field.name == kStackField)
      for (const auto& values : field.values)
        for (const double stack : values)
          if (stack > 0) ++stacks[stack];
  return stacks;
}

// Of the whole mesh: every stack, and the parts that have some of it. On all ranks.
std::map<double, int> parts_of_stacks(const PartitionedMesh& mesh) {
  MessageWriter writer;
  for (const PartId part : mesh.local()) {
    std::vector<double> own;
    for (const auto& [stack, cells] : stacks_of(mesh.parts.at(part).mesh)) own.push_back(stack);
    writer.put_array(std::span<const double>(own));
  }
  std::map<double, int> parts;
  for (const Bytes& bytes : mesh.communicator->all_gather(writer.take()))
    for (MessageReader reader(bytes); !reader.at_end();)
      for (const double stack : reader.get_view<double>()) ++parts[stack];
  return parts;
}

void check_stacks(const PartitionedMesh& mesh, std::size_t stacks) {
  const std::map<double, int> parts = parts_of_stacks(mesh);
  CHECK(parts.size() == stacks);
  CHECK(std::ranges::all_of(parts, [](const auto& stack) { return stack.second == 1; }));
}

std::size_t count_stacks(const Mesh& mesh) {
  const auto field = std::ranges::find(mesh.cell_fields, kStackField, &MeshField::name);
  std::set<double> stacks(field->values.begin(), field->values.end());
  return stacks.size() - stacks.count(0);
}

// The parts are the mesh of one piece, with its fields; the result on ranks as well.
void check_same(const GeometricModel& model, const MeshOptions& options) {
  const MeshResult whole = make_mesh(model, options);
  REQUIRE(whole.status == MeshStatus::Ok);
  REQUIRE(count_stacks(whole.mesh) > 0);
  const auto communicator = make_communicator();
  MeshInPartsResult parts = make_mesh_in_parts(model, options, *communicator);
  REQUIRE(parts.run.status == MeshStatus::Ok);
  REQUIRE(parts.mesh);
  const TaskRunner runner(options.threads);
  test::check_links(*parts.mesh, runner);
  check_stacks(*parts.mesh, count_stacks(whole.mesh));
  CHECK(parts.run.layers.prisms == whole.layers.prisms);
  CHECK(parts.run.layers.coverage.thickness == whole.layers.coverage.thickness);
  CHECK(parts.run.layers.limited.size() == whole.layers.limited.size());
  const Mesh gathered = gather_mesh(*parts.mesh, runner);
  const MeshResult ranks = make_mesh_on_ranks(model, options, *communicator);
  CHECK(ranks.status == MeshStatus::Ok);
  if (communicator->rank() != 0) return;
  CHECK(validate_mesh(gathered).valid());
  CHECK(mesh_digest(gathered) == mesh_digest(whole.mesh));
  CHECK(field_digest(gathered) == field_digest(whole.mesh));
  CHECK(gathered.points == whole.mesh.points);  // global ids are the numbers of make_mesh
  CHECK(ranks.mesh.points == whole.mesh.points);
  CHECK(ranks.mesh.prism_to_vert == whole.mesh.prism_to_vert);
  CHECK(mesh_digest(ranks.mesh) == mesh_digest(whole.mesh));
}

}  // namespace

TEST_CASE("layers in the parts in which a volume was filled are those of one piece") {
  const auto box = make_box({0, 0, 0}, {1, 1, 1});
  MeshOptions options = with_layers(*box, 0.1);
  options.tets_per_part = 2000;
  check_same(*box, options);
}

TEST_CASE("layers that stand on side faces go along to as many parts as are asked for") {
  const auto pipe = make_cylinder(1, 3);
  for (const int parts : {1, 5, 64}) {
    CAPTURE(parts);
    MeshOptions options = with_layers(*pipe, 0.35);
    // The wall alone: the ends are the faces of radius 1.
    std::erase_if(options.layers.walls,
                  [&](const WallLayers& wall) { return std::abs(pipe->area(wall.face) - std::numbers::pi) < 0.01; });
    REQUIRE_FALSE(options.layers.walls.empty());
    options.parts = parts;
    check_same(*pipe, options);
  }
}

TEST_CASE("layers that are split into tets stay in stacks") {
  const auto box = make_box({0, 0, 0}, {1, 1, 1});
  MeshOptions options = with_layers(*box, 0.2, 2);
  options.layers.all_tets = true;
  options.parts = 7;
  check_same(*box, options);
}

TEST_CASE("fans at sharp edges lie in one part each") {
  const auto around = put_into_box(make_box({0, 0, 0}, {1, 1, 1}), 3);
  MeshOptions options = with_layers(*around, 0.3, 6);
  for (const bool all_tets : {false, true}) {
    options.layers.all_tets = all_tets;
    options.parts = 5;
    check_same(*around, options);
  }
}

TEST_CASE("points of meshes with layers may have numbers beyond 32 bits") {
  const auto around = put_into_box(make_box({0, 0, 0}, {1, 1, 1}), 3);
  MeshOptions options = with_layers(*around, 0.3, 6);
  options.parts = 5;
  first_number() = GENERATE(std::uint64_t{1} << 33, (std::uint64_t{1} << 32) - 500);
  const std::shared_ptr<void> back(nullptr, [](void*) { first_number() = 0; });
  for (const bool all_tets : {false, true}) {
    options.layers.all_tets = all_tets;
    check_same(*around, options);
  }
}

TEST_CASE("layers of several regions lie in several parts") {
  const auto model = ball_in_box();
  MeshOptions options = with_layers(*model, 0.35);
  check_same(*model, options);
  options.parts = 3;
  check_same(*model, options);
}

TEST_CASE("parts that are dealt anew keep stacks in one part") {
  const auto box = make_box({0, 0, 0}, {1, 1, 1});
  MeshOptions options = with_layers(*box, 0.12);
  options.parts = 6;
  const auto communicator = make_communicator();
  MeshInPartsResult result = make_mesh_in_parts(*box, options, *communicator);
  REQUIRE(result.mesh);
  const TaskRunner runner(2);
  const std::size_t stacks = parts_of_stacks(*result.mesh).size();
  for (const PartitionMethod method :
       {PartitionMethod::Multilevel, PartitionMethod::Rcb, PartitionMethod::Sfc, PartitionMethod::Scotch})
    for (const std::size_t parts : {4, 12, 5}) {
      CAPTURE(to_string(method), parts);
      deal_cells(*result.mesh, {.part_count = parts, .method = method, .weights = {}}, runner);
      check_stacks(*result.mesh, stacks);
      const bool by_zoltan = method == PartitionMethod::Scotch && communicator->rank_count() > 1;
      if (!by_zoltan) CHECK(measure_parts(*result.mesh).element_imbalance < 0.1);
    }
  test::check_links(*result.mesh, runner);
}

TEST_CASE("parts with layers are cancelled at any stage, and there is no mesh then") {
  const auto box = make_box({0, 0, 0}, {1, 1, 1});
  for (const Stage stage : {Stage::Layers, Stage::Volume, Stage::Partition}) {
    Host host;
    host.progress = [&](const ProgressEvent& event) { return event.stage != stage; };
    MeshOptions options = with_layers(*box, 0.15);
    options.parts = 3;
    const auto communicator = make_communicator();
    const MeshInPartsResult result = make_mesh_in_parts(*box, options, *communicator, host);
    CHECK(result.run.status == MeshStatus::Cancelled);
    CHECK_FALSE(result.mesh);
  }
}
