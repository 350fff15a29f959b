#include <algorithm>
#include <catch2/catch.hpp>
#include <limits>
#include <numeric>
#include <thread>
#include <vector>

#include "tests/support/tet_lattice.hpp"
#include "tetloom/error.hpp"
#include "tetloom/tasks.hpp"
#include "threading/balance/graph_partitioners.hpp"
#include "threading/balance/part_boundaries.hpp"
#include "threading/balance/partition_figures.hpp"
#include "threading/balance/partitioners.hpp"
#include "threading/comm/simulated_ranks.hpp"

using namespace tetloom;

namespace {

struct Graph {
  std::vector<std::uint64_t> first{0};
  std::vector<std::uint32_t> neighbours;
};

Graph graph_of(const test::TetLattice& lattice) {
  Graph graph;
  for (std::size_t code = 0; code < lattice.neighbours.size(); ++code) {
    if (lattice.neighbours[code] != TargetedTets::kNoNeighbour)
      graph.neighbours.push_back(lattice.neighbours[code] / 4);
    if (code % 4 == 3) graph.first.push_back(graph.neighbours.size());
  }
  return graph;
}

std::vector<std::uint32_t> bisect(const test::TetLattice& lattice, std::uint32_t parts) {
  std::vector<std::uint32_t> targets(lattice.centroids.size());
  const std::vector<ItemBlock> blocks{{lattice.centroids, {}, targets, lattice.neighbours}};
  on_simulated_ranks(1, [&](Communicator& communicator) { partition_rcb(blocks, parts, communicator, TaskRunner(2)); });
  return targets;
}

PartitionFigures measure(const test::TetLattice& lattice, std::vector<std::uint32_t>& targets, std::uint32_t parts) {
  return measure_partition({lattice.neighbours, {}, targets, parts}, lattice.tet_to_vert, lattice.vertex_count);
}

}  // namespace

TEST_CASE("bisection and smoothing cut few more faces than Scotch") {
  const std::vector<std::pair<test::Solid, double>> cases{
      {test::in_ball, 1.25}, {test::in_drilled_block, 1.2}, {test::in_bracket, 1.2}};
  for (const auto& [solid, ratio] : cases) {
    const test::TetLattice lattice = test::make_tet_lattice(32, solid);
    const Graph graph = graph_of(lattice);
    auto by_scotch = bisect(lattice, 16), targets = by_scotch;
    partition_scotch({graph.first, graph.neighbours, {}}, 16, 0.03, by_scotch);
    const PartitionFigures before = measure(lattice, targets, 16);
    smooth_part_boundaries({lattice.neighbours, {}, targets, 16}, TaskRunner(2));
    const PartitionFigures after = measure(lattice, targets, 16), peer = measure(lattice, by_scotch, 16);
    CAPTURE(before.cut_faces, after.cut_faces, peer.cut_faces);
    CHECK(after.cut_faces < before.cut_faces);
    CHECK(static_cast<double>(after.cut_faces) < ratio * static_cast<double>(peer.cut_faces));
    CHECK(after.element_imbalance <= 0.03);
    CHECK(peer.element_imbalance <= 0.04);
  }
}

TEST_CASE("smoothing gives the same on any number of threads and keeps the bound with weights") {
  const test::TetLattice lattice = test::make_tet_lattice(16, test::in_ball);
  std::vector<std::int64_t> weights(lattice.centroids.size());
  for (std::size_t i = 0; i < weights.size(); ++i) weights[i] = 1 + static_cast<std::int64_t>(i * 7 % 5);
  const auto start = bisect(lattice, 6);
  std::vector<std::uint32_t> expected;
  for (const int threads : {1, 2, 5}) {
    auto targets = start;
    const TargetedTets tets{lattice.neighbours, weights, targets, 6};
    const PartitionFigures before = measure_partition(tets);
    smooth_part_boundaries(tets, TaskRunner(threads));
    CHECK(measure_partition(tets).weight_imbalance <= std::max(0.03, before.weight_imbalance));
    if (expected.empty()) expected = targets;
    CHECK(targets == expected);
  }
}

TEST_CASE("smoothing never cuts more faces, from any start") {
  const test::TetLattice lattice = test::make_tet_lattice(10, test::in_ball);
  for (const std::uint32_t stride : {1U, 3U, 50U, 1000U}) {
    std::vector<std::uint32_t> targets(lattice.centroids.size());
    for (std::size_t i = 0; i < targets.size(); ++i) targets[i] = static_cast<std::uint32_t>(i / stride % 5);
    const auto before = measure(lattice, targets, 5).cut_faces;
    smooth_part_boundaries({lattice.neighbours, {}, targets, 5}, TaskRunner(2), {.sweeps = 3});
    CHECK(measure(lattice, targets, 5).cut_faces <= before);
  }
}

TEST_CASE("diffusion evens out targets that are a little off") {
  const test::TetLattice lattice = test::make_tet_lattice(20, test::in_ball);
  auto targets = bisect(lattice, 8);
  for (std::size_t i = 0; i < targets.size(); ++i)
    if (lattice.centroids[i].x > 0.5F && lattice.centroids[i].x < 0.53F && targets[i] != 0) targets[i] = 0;
  const PartitionFigures before = measure(lattice, targets, 8);
  auto again = targets;
  const std::int64_t moved = diffuse_load({lattice.neighbours, {}, targets, 8});
  const PartitionFigures after = measure(lattice, targets, 8);
  CAPTURE(before.element_imbalance, after.element_imbalance, moved);
  CHECK(before.element_imbalance > 0.1);
  CHECK(after.element_imbalance < 0.02);
  CHECK(moved > 0);
  CHECK(diffuse_load({lattice.neighbours, {}, again, 8}) == moved);
  CHECK(again == targets);
}

TEST_CASE("figures of two tets that share a face") {
  const std::vector<std::uint32_t> none(8, TargetedTets::kNoNeighbour), corners{0, 1, 2, 3, 1, 2, 3, 4};
  auto neighbours = none;
  neighbours[0] = 7;
  neighbours[7] = 0;
  std::vector<std::uint32_t> targets{2, 0};
  const std::vector<std::int64_t> weights{1, 2};
  const PartitionFigures figures = measure_partition({neighbours, weights, targets, 3}, corners, 5);
  CHECK(figures.elements == std::vector<std::int64_t>{1, 0, 1});
  CHECK(figures.weights == std::vector<std::int64_t>{2, 0, 1});
  CHECK(figures.vertices == std::vector<std::int64_t>{4, 0, 4});
  CHECK(figures.neighbours == std::vector<std::uint32_t>{1, 0, 1});
  CHECK(figures.cut_faces == 1);
  CHECK(figures.element_imbalance == Approx(0.5));
  CHECK(figures.weight_imbalance == Approx(1));
}

TEST_CASE("arrays that do not fit, targets out of range and weights of zero are refused") {
  const std::vector<std::uint32_t> neighbours(8, TargetedTets::kNoNeighbour);
  std::vector<std::uint32_t> targets{0, 3}, one{0};
  const std::vector<std::int64_t> zero{0, 1};
  const TaskRunner runner(1);
  CHECK_THROWS_AS(smooth_part_boundaries({neighbours, {}, targets, 3}, runner), Error);
  CHECK_THROWS_AS(smooth_part_boundaries({neighbours, {}, one, 3}, runner), Error);
  CHECK_THROWS_AS(diffuse_load({neighbours, zero, targets, 4}), Error);
  CHECK_THROWS_AS(measure_partition({neighbours, {}, targets, 3}), Error);
}

TEST_CASE("Scotch gives the same each time and from several threads at once") {
  const test::TetLattice lattice = test::make_tet_lattice(14, test::in_ball);
  const Graph graph = graph_of(lattice);
  std::vector<std::int64_t> weights(lattice.centroids.size(), std::int64_t{1} << 40);
  std::vector<std::vector<std::uint32_t>> found(4, std::vector<std::uint32_t>(lattice.centroids.size()));
  {
    std::vector<std::jthread> threads;
    for (auto& targets : found)
      threads.emplace_back([&] { partition_scotch({graph.first, graph.neighbours, weights}, 7, 0.03, targets); });
  }
  for (const auto& targets : found) CHECK(targets == found[0]);
  CHECK(measure(lattice, found[0], 7).element_imbalance < 0.05);
}

TEST_CASE("Scotch is not asked about graphs that do not fit") {
  const std::vector<std::uint64_t> first{0, 1, 2};
  const std::vector<std::uint32_t> good{1, 0}, beyond{1, 2};
  const std::vector<std::int64_t> zero{1, 0};
  std::vector<std::uint32_t> targets(2), short_one(1);
  CHECK_THROWS_AS(partition_scotch({first, beyond, {}}, 2, 0.03, targets), Error);
  CHECK_THROWS_AS(partition_scotch({first, good, zero}, 2, 0.03, targets), Error);
  CHECK_THROWS_AS(partition_scotch({first, good, {}}, 2, 0.03, short_one), Error);
  CHECK_THROWS_AS(partition_scotch({first, good, {}}, 0, 0.03, targets), Error);
  partition_scotch({first, good, {}}, 2, 0.03, targets);
  CHECK(targets[0] != targets[1]);
  partition_scotch({first, good, {}}, 5, 0.03, targets);
  CHECK(std::ranges::all_of(targets, [](std::uint32_t t) { return t < 5; }));
}
