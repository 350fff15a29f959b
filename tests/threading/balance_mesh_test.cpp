// Destinations for whole meshes in parts: balance, laws, refusals.
#include <algorithm>
#include <catch2/catch.hpp>
#include <limits>

#include "tests/support/mixed_mesh.hpp"
#include "tests/threading/communicators.hpp"
#include "tests/threading/part_cases.hpp"
#include "tetloom/partition.hpp"
#include "tetloom/tasks.hpp"

using namespace tetloom;
using namespace tetloom::test;

namespace {

// Weight of each part on all ranks; without a field, its cells.
std::vector<std::int64_t> weigh_parts(const PartitionedMesh& mesh, const std::string& field) {
  std::vector<std::int64_t> weights(mesh.part_count(), 0);
  for (const PartId id : mesh.local()) {
    const PartMesh& part = mesh.parts.at(id).mesh;
    if (field.empty()) weights[id.value] = static_cast<std::int64_t>(part.cell_count());
    for (const CellField& candidate : part.cell_fields)
      if (candidate.name == field)
        for (const auto& values : candidate.values)
          for (const double value : values) weights[id.value] += static_cast<std::int64_t>(value);
  }
  mesh.communicator->sum(weights);
  return weights;
}

double imbalance_of(const std::vector<std::int64_t>& weights) {
  std::int64_t total = 0;
  for (const std::int64_t w : weights) total += w;
  const double mean = static_cast<double>(total) / static_cast<double>(weights.size());
  return static_cast<double>(*std::max_element(weights.begin(), weights.end())) / mean - 1;
}

void rebalance(PartitionedMesh& mesh, const BalanceOptions& options, const TaskRunner& runner) {
  migrate(mesh, compute_destinations(mesh, options, runner), options.part_count, runner);
}

Mesh make_weighted_box() {
  Mesh mesh = make_tet_box(12, 10, 8, 5);
  MeshField weights{"work", 1, {}};
  for (const auto& tet : mesh.tet_to_vert) weights.values.push_back(mesh.points[tet[0]].x < 3 ? 8 : 1);
  mesh.cell_fields.push_back(weights);
  return mesh;
}

}  // namespace

TEST_CASE("every method deals a mesh in balance, from one part and from several") {
  const auto communicator = make_communicator();
  const TaskRunner runner(2);
  const Mesh original = make_weighted_box();
  const Whole whole = describe_whole(original);
  for (const PartitionMethod method : {PartitionMethod::Rcb, PartitionMethod::Sfc, PartitionMethod::Scotch}) {
    for (const std::string field : {"", "work"}) {
      CAPTURE(to_string(method), field);
      PartitionedMesh mesh = distribute_mesh(original, *communicator);
      for (const std::size_t part_count : {4, 12, 7, 3, 30}) {
        CAPTURE(part_count);
        BalanceOptions options;
        options.part_count = part_count;
        options.method = method;
        options.weights = field;
        rebalance(mesh, options, runner);
        CHECK(mesh.part_count() == part_count);
        // Zoltan keeps its bound only roughly on so small a mesh.
        const bool by_zoltan = method == PartitionMethod::Scotch && communicator->rank_count() > 1;
        CHECK(imbalance_of(weigh_parts(mesh, field)) <= (by_zoltan ? 0.3 : 0.08));
        check_links(mesh, runner);
      }
      check_whole(mesh, runner, whole);
    }
  }
}

TEST_CASE("a field of weights that cannot be one is refused") {
  const auto communicator = make_communicator();
  const TaskRunner runner(2);
  Mesh original = make_weighted_box();
  original.cell_fields.push_back({"pair", 2, std::vector<double>(2 * original.tet_to_vert.size(), 1)});
  original.cell_fields.push_back({"holes", 1, std::vector<double>(original.tet_to_vert.size(), 1)});
  original.cell_fields.back().values[7] = std::numeric_limits<double>::quiet_NaN();
  original.cell_fields.push_back({"debts", 1, std::vector<double>(original.tet_to_vert.size(), 1)});
  original.cell_fields.back().values[8] = -1;
  const PartitionedMesh mesh = distribute_mesh(original, *communicator);
  for (const std::string field : {"none", "pair", "holes", "debts"}) {
    for (const PartitionMethod method : {PartitionMethod::Rcb, PartitionMethod::Sfc, PartitionMethod::Scotch}) {
      CAPTURE(field, to_string(method));
      BalanceOptions options;
      options.part_count = 4;
      options.method = method;
      options.weights = field;
      CHECK_THROWS_AS(compute_destinations(mesh, options, runner), Error);
    }
  }
  BalanceOptions none;
  none.part_count = 0;
  CHECK_THROWS_AS(compute_destinations(mesh, none, runner), Error);
}

TEST_CASE("a mesh with fewer cells than parts leaves parts empty") {
  const auto communicator = make_communicator();
  const TaskRunner runner(2);
  const Mesh original = make_tet_box(1, 1, 1);
  PartitionedMesh mesh = distribute_mesh(original, *communicator);
  BalanceOptions options;
  options.part_count = 20;
  for (const PartitionMethod method : {PartitionMethod::Rcb, PartitionMethod::Sfc}) {
    options.method = method;
    rebalance(mesh, options, runner);
    check_links(mesh, runner);
    check_whole(mesh, runner, describe_whole(original));
  }
}
