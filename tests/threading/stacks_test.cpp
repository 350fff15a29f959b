// Cells of one stack go to one part, whatever deals them and wherever they come from.
#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <map>
#include <set>

#include "tests/support/mixed_mesh.hpp"
#include "tests/threading/communicators.hpp"
#include "tests/threading/part_cases.hpp"
#include "tetloom/partition.hpp"
#include "tetloom/tasks.hpp"

using namespace tetloom;
using namespace tetloom::test;

namespace {

// Cells whose centroids lie above the same unit square and below z = 3, with numbers as a file may have them.
double stack_at(const Vec3& x) { return x.z > 3 ? 0 : 1000 + 100 * std::floor(x.x) + std::floor(x.y); }

Mesh with_stacks(Mesh mesh) {
  MeshField field{std::string(kStackField), 1, {}};
  const auto add = [&](const auto& cells) {
    for (const auto& cell : cells) {
      Vec3 sum{};
      for (const std::uint32_t v : cell) sum = sum + mesh.points[v];
      field.values.push_back(stack_at((1.0 / static_cast<double>(cell.size())) * sum));
    }
  };
  add(mesh.tet_to_vert), add(mesh.pyramid_to_vert), add(mesh.prism_to_vert), add(mesh.hex_to_vert);
  mesh.cell_fields.push_back(std::move(field));
  return mesh;
}

// The parts that have cells of each stack, on all ranks.
std::map<double, std::set<std::uint32_t>> parts_of_stacks(const PartitionedMesh& mesh) {
  MessageWriter writer;
  for (const PartId id : mesh.local())
    for (const CellField& field : mesh.parts.at(id).mesh.cell_fields)
      if (field.name == kStackField)
        for (const auto& values : field.values)
          for (const double stack : values) writer.put(stack), writer.put(id.value);
  std::map<double, std::set<std::uint32_t>> parts;
  for (const Bytes& bytes : mesh.communicator->all_gather(writer.take()))
    for (MessageReader reader(bytes); !reader.at_end();) {
      const auto stack = reader.get<double>();
      parts[stack].insert(reader.get<std::uint32_t>());
    }
  return parts;
}

std::size_t cut_stacks(const PartitionedMesh& mesh) {
  std::size_t cut = 0;
  for (const auto& [stack, parts] : parts_of_stacks(mesh)) cut += stack > 0 && parts.size() > 1;
  return cut;
}

void deal_and_check(PartitionedMesh& mesh, const BalanceOptions& options, const TaskRunner& runner) {
  CAPTURE(to_string(options.method), options.part_count, options.weights);
  deal_cells(mesh, options, runner);
  CHECK(mesh.part_count() == options.part_count);
  CHECK(cut_stacks(mesh) == 0);
  check_links(mesh, runner);
}

constexpr std::array<PartitionMethod, 4> kMethods{PartitionMethod::Multilevel, PartitionMethod::Rcb,
                                                  PartitionMethod::Sfc, PartitionMethod::Scotch};

}  // namespace

TEST_CASE("no method cuts a stack, of tets or of all kinds of cells") {
  const auto communicator = make_communicator();
  const TaskRunner runner(2);
  for (const Mesh& original : {with_stacks(make_tet_box(8, 8, 6, 5)), with_stacks(make_mixed_box(8, 8, 6, 5))}) {
    for (const PartitionMethod method : kMethods) {
      PartitionedMesh mesh = distribute_mesh(original, *communicator);
      BalanceOptions options;
      options.method = method;
      for (const std::size_t parts : {4, 12, 7}) {
        options.part_count = parts;
        deal_and_check(mesh, options, runner);
        // A stack is up to a third of a part here.
        CHECK(measure_parts(mesh).element_imbalance < 0.6);
      }
      check_whole(mesh, runner, describe_whole(original));
    }
  }
}

TEST_CASE("a stack weighs as much as its cells") {
  const auto communicator = make_communicator();
  const TaskRunner runner(2);
  Mesh original = with_stacks(make_tet_box(16, 4, 6));
  MeshField work{"work", 1, {}};
  for (const auto& tet : original.tet_to_vert) work.values.push_back(original.points[tet[0]].x < 4 ? 8 : 1);
  original.cell_fields.push_back(work);
  PartitionedMesh mesh = distribute_mesh(original, *communicator);
  BalanceOptions options;
  options.part_count = 4;
  options.weights = "work";
  deal_and_check(mesh, options, runner);
  CHECK(measure_parts(mesh, "work").weight_imbalance < 0.2);
}

TEST_CASE("stacks that come cut are put together") {
  const auto communicator = make_communicator();
  const TaskRunner runner(2);
  const Mesh original = with_stacks(make_mixed_box(6, 6, 6, 3));
  for (const PartitionMethod method : kMethods)
    for (const std::size_t parts : {5, 10, 3}) {
      PartitionedMesh mesh = distribute_mesh(original, *communicator);
      migrate(mesh, deal(mesh, 5, Dealing::Scatter, 7), 5, runner);
      REQUIRE(cut_stacks(mesh) > 10);
      BalanceOptions options;
      options.method = method;
      options.part_count = parts;
      deal_and_check(mesh, options, runner);
      check_whole(mesh, runner, describe_whole(original));
    }
}

TEST_CASE("values that are no numbers of stacks bind nothing together") {
  const auto communicator = make_communicator();
  const TaskRunner runner(2);
  Mesh original = make_tet_box(6, 6, 6);
  const std::array<double, 5> values{-1, 0.5, NAN, INFINITY, 0};
  MeshField field{std::string(kStackField), 1, {}};
  for (std::size_t i = 0; i < original.tet_to_vert.size(); ++i) field.values.push_back(values[i % values.size()]);
  original.cell_fields.push_back(field);
  PartitionedMesh mesh = distribute_mesh(original, *communicator);
  BalanceOptions options;
  options.part_count = 6;
  deal_cells(mesh, options, runner);
  CHECK(measure_parts(mesh).element_imbalance < 0.05);
}
