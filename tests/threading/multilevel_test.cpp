#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <vector>

#include "tests/support/tet_lattice.hpp"
#include "tetloom/error.hpp"
#include "tetloom/tasks.hpp"
#include "threading/balance/aggregation_detail.hpp"
#include "threading/balance/graph_partitioners.hpp"
#include "threading/balance/multilevel.hpp"
#include "threading/balance/partition_figures.hpp"

using namespace tetloom;

namespace {

std::vector<std::uint32_t> partition(const test::TetLattice& lattice, std::span<const std::int64_t> weights,
                                     std::uint32_t parts, int threads = 2, double imbalance = 0.03) {
  std::vector<std::uint32_t> targets(lattice.centroids.size(), 77);
  partition_multilevel({lattice.neighbours, weights, targets, parts}, lattice.centroids, TaskRunner(threads),
                       imbalance);
  return targets;
}

PartitionFigures measure(const test::TetLattice& lattice, std::span<const std::int64_t> weights,
                         std::vector<std::uint32_t>& targets, std::uint32_t parts) {
  return measure_partition({lattice.neighbours, weights, targets, parts});
}

std::int64_t cut_of_scotch(const test::TetLattice& lattice, std::uint32_t parts) {
  std::vector<std::uint64_t> first{0};
  std::vector<std::uint32_t> neighbours, targets(lattice.centroids.size());
  for (std::size_t code = 0; code < lattice.neighbours.size(); ++code) {
    if (lattice.neighbours[code] != TargetedTets::kNoNeighbour) neighbours.push_back(lattice.neighbours[code] / 4);
    if (code % 4 == 3) first.push_back(neighbours.size());
  }
  partition_scotch({first, neighbours, {}}, parts, 0.03, targets);
  return measure(lattice, {}, targets, parts).cut_faces;
}

/// Some tets are many times as heavy as others, and the heavy ones lie together.
std::vector<std::int64_t> uneven_weights(const test::TetLattice& lattice) {
  std::vector<std::int64_t> weights;
  for (const Point3f& place : lattice.centroids)
    weights.push_back(1 + static_cast<std::int64_t>(200 * place.x * place.x * place.x));
  return weights;
}

bool lies_apart(float x, float, float) { return x < 0.3F || x > 0.6F; }

}  // namespace

TEST_CASE("levels of clusters cut few more faces than Scotch, within the bound") {
  struct Case {
    test::Solid solid;
    std::uint32_t cells;
    double ratio;
  };
  // A ball can be halved in many ways that cost nearly the same, so that luck matters more.
  const std::vector<Case> cases{
      {test::in_ball, 32, 1.2}, {test::in_drilled_block, 40, 1.15}, {test::in_bracket, 40, 1.15}};
  for (const auto& [solid, cells, ratio] : cases) {
    const test::TetLattice lattice = test::make_tet_lattice(cells, solid);
    for (const std::uint32_t parts : {8U, 11U, 16U}) {
      auto targets = partition(lattice, {}, parts);
      const PartitionFigures figures = measure(lattice, {}, targets, parts);
      const std::int64_t peer = cut_of_scotch(lattice, parts);
      CAPTURE(lattice.centroids.size(), parts, figures.cut_faces, peer);
      CHECK(static_cast<double>(figures.cut_faces) <= ratio * static_cast<double>(peer));
      CHECK(figures.element_imbalance <= 0.03);
    }
  }
}

TEST_CASE("levels give the same on any number of threads") {
  const test::TetLattice lattice = test::make_tet_lattice(36, test::in_ball);
  const auto weights = uneven_weights(lattice);
  for (const bool weighted : {false, true}) {
    const std::span<const std::int64_t> used = weighted ? std::span(weights) : std::span<const std::int64_t>{};
    const auto expected = partition(lattice, used, 9, 1);
    for (const int threads : {1, 2, 5}) CHECK(partition(lattice, used, 9, threads) == expected);
  }
}

TEST_CASE("levels balance weights, not counts") {
  const test::TetLattice lattice = test::make_tet_lattice(28, test::in_bracket);
  const auto weights = uneven_weights(lattice);
  for (const double imbalance : {0.01, 0.03, 0.1}) {
    auto targets = partition(lattice, weights, 6, 2, imbalance);
    const PartitionFigures figures = measure(lattice, weights, targets, 6);
    CHECK(figures.weight_imbalance <= imbalance);
    CHECK(figures.element_imbalance > 0.2);
  }
}

TEST_CASE("places crowded on one side change chunks, and neither balance nor the cut much") {
  test::TetLattice lattice = test::make_tet_lattice(36, test::in_drilled_block);
  for (Point3f& place : lattice.centroids) place.x = std::pow(place.x, 6.0F);
  auto targets = partition(lattice, {}, 12);
  const PartitionFigures figures = measure(lattice, {}, targets, 12);
  CHECK(figures.element_imbalance <= 0.03);
  CHECK(static_cast<double>(figures.cut_faces) <= 1.15 * static_cast<double>(cut_of_scotch(lattice, 12)));
}

TEST_CASE("pieces that do not touch are dealt in balance") {
  const test::TetLattice lattice = test::make_tet_lattice(24, lies_apart);
  for (const std::uint32_t parts : {3U, 5U, 8U}) {
    auto targets = partition(lattice, {}, parts);
    CHECK(measure(lattice, {}, targets, parts).element_imbalance <= 0.03);
  }
}

TEST_CASE("tets without any neighbour are dealt in balance") {
  test::TetLattice lattice = test::make_tet_lattice(8, test::in_bracket);
  std::ranges::fill(lattice.neighbours, TargetedTets::kNoNeighbour);
  auto targets = partition(lattice, {}, 4);
  const PartitionFigures figures = measure(lattice, {}, targets, 4);
  CHECK(figures.cut_faces == 0);
  CHECK(figures.element_imbalance <= 0.05);
}

TEST_CASE("one part, one tet, no tet, and more parts than tets") {
  const test::TetLattice lattice = test::make_tet_lattice(3, test::in_bracket);
  const std::size_t count = lattice.centroids.size();
  CHECK(partition(lattice, {}, 1) == std::vector<std::uint32_t>(count, 0));
  const auto many = partition(lattice, {}, static_cast<std::uint32_t>(3 * count));
  CHECK(std::ranges::all_of(many, [&](std::uint32_t target) { return target < 3 * count; }));
  test::TetLattice one;
  CHECK(partition(one, {}, 4).empty());
  one.centroids.push_back({0, 0, 0});
  one.neighbours.assign(4, TargetedTets::kNoNeighbour);
  CHECK(partition(one, {}, 1).at(0) == 0);
  CHECK(partition(one, {}, 4).at(0) < 4);
}

TEST_CASE("levels refuse arrays that do not fit and values that are not sound") {
  test::TetLattice lattice = test::make_tet_lattice(3, test::in_bracket);
  const std::vector<std::int64_t> zeros(lattice.centroids.size(), 0), few(1, 1);
  CHECK_THROWS_AS(partition(lattice, zeros, 2), Error);
  CHECK_THROWS_AS(partition(lattice, few, 2), Error);
  CHECK_THROWS_AS(partition(lattice, {}, 0), Error);
  CHECK_THROWS_AS(partition(lattice, {}, 2, 1, -0.1), Error);
  lattice.centroids[5].y = std::numeric_limits<float>::quiet_NaN();
  CHECK_THROWS_AS(partition(lattice, {}, 2), Error);
  lattice.centroids.pop_back();
  CHECK_THROWS_AS(partition(lattice, {}, 2), Error);
}

TEST_CASE("clusters keep weight and faces, within their chunks, in numbers that leave none out") {
  using namespace balance_detail;
  const test::TetLattice lattice = test::make_tet_lattice(30, test::in_ball);
  const auto weights = uneven_weights(lattice);
  const TaskRunner runner(2);
  std::vector<std::uint32_t> cluster_of(lattice.centroids.size()), targets(lattice.centroids.size());
  const TetGraph graph({lattice.neighbours, weights, targets, 1});
  const Chunks chunks = find_chunks(lattice.centroids, cluster_of, runner);
  const Chunks clusters = aggregate(graph, chunks, {10, 1 << 30}, cluster_of, runner);
  const ClusterGraph coarse = contract(graph, chunks, clusters, cluster_of, runner);
  CHECK(chunks.count() > 1);
  CHECK(coarse.size() == clusters.begin.back());
  CHECK(coarse.size() < lattice.centroids.size() / 6);
  std::vector<std::int64_t> expected(coarse.size(), 0);
  std::int64_t between = 0, links = 0;
  for (std::uint32_t tet = 0; tet < cluster_of.size(); ++tet) {
    expected.at(cluster_of[tet]) += weights[tet];
    graph.for_links(tet, [&](std::uint32_t other, std::uint32_t) { between += cluster_of[tet] != cluster_of[other]; });
  }
  CHECK(expected == coarse.weights);
  CHECK(std::ranges::all_of(coarse.weights, [](std::int64_t weight) { return weight > 0; }));
  for (const std::uint32_t link : coarse.links) links += link;
  CHECK(links == between);
  for (std::size_t chunk = 0; chunk < chunks.count(); ++chunk)
    for (std::uint32_t at = chunks.begin[chunk]; at < chunks.begin[chunk + 1]; ++at) {
      const std::uint32_t cluster = cluster_of[chunks.node(at)];
      REQUIRE((cluster >= clusters.begin[chunk] && cluster < clusters.begin[chunk + 1]));
    }
}
