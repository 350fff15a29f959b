#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <numeric>
#include <random>
#include <vector>

#include "core/spatial/hilbert.hpp"
#include "tetloom/tasks.hpp"
#include "threading/balance/partitioners.hpp"
#include "threading/comm/simulated_ranks.hpp"

using namespace tetloom;

namespace {

struct Cloud {
  std::vector<Point3f> points;
  std::vector<double> weights;
};

Cloud make_cloud(std::size_t count, bool weighted, unsigned seed) {
  std::mt19937 random(seed);
  std::normal_distribution<float> normal;
  std::uniform_real_distribution<double> weight(0.1, 5);
  Cloud cloud;
  for (std::size_t i = 0; i < count; ++i) {
    cloud.points.push_back({normal(random), 2 * normal(random), std::abs(normal(random))});
    if (weighted) cloud.weights.push_back(weight(random));
  }
  return cloud;
}

enum class Method { Rcb, RcbAxes, Sfc };
const std::vector<Method> kMethods{Method::Rcb, Method::RcbAxes, Method::Sfc};

void partition(Method method, std::span<const ItemBlock> blocks, std::uint32_t parts, Communicator& communicator,
               const TaskRunner& runner) {
  if (method == Method::Sfc) return partition_sfc(blocks, parts, communicator, runner);
  partition_rcb(blocks, parts, communicator, runner, method == Method::Rcb ? CutPlanes::Several : CutPlanes::Axes);
}

/// Item i lies on rank i % ranks, in block i / ranks % blocks.
std::vector<std::uint32_t> targets_of(const Cloud& cloud, Method method, std::uint32_t parts, int ranks = 1,
                                      std::size_t blocks = 1, int threads = 1) {
  std::vector<std::uint32_t> targets(cloud.points.size());
  on_simulated_ranks(ranks, [&](Communicator& communicator) {
    std::vector<Cloud> own(blocks);
    std::vector<std::vector<std::size_t>> index(blocks);
    for (std::size_t i = communicator.rank(); i < cloud.points.size(); i += ranks) {
      const std::size_t b = i / ranks % blocks;
      own[b].points.push_back(cloud.points[i]);
      if (!cloud.weights.empty()) own[b].weights.push_back(cloud.weights[i]);
      index[b].push_back(i);
    }
    std::vector<std::vector<std::uint32_t>> found(blocks);
    std::vector<ItemBlock> views;
    for (std::size_t b = 0; b < blocks; ++b) {
      found[b].resize(index[b].size(), 77);
      views.push_back({own[b].points, own[b].weights, found[b]});
    }
    partition(method, views, parts, communicator, TaskRunner(threads));
    for (std::size_t b = 0; b < blocks; ++b)
      for (std::size_t k = 0; k < index[b].size(); ++k) targets[index[b][k]] = found[b][k];
  });
  return targets;
}

std::vector<double> weight_by_target(const Cloud& cloud, std::span<const std::uint32_t> targets, std::size_t parts) {
  std::vector<double> weights(parts, 0);
  for (std::size_t i = 0; i < targets.size(); ++i)
    weights.at(targets[i]) += cloud.weights.empty() ? 1 : cloud.weights[i];
  return weights;
}

double imbalance(std::span<const double> weights) {
  const double sum = std::accumulate(weights.begin(), weights.end(), 0.0);
  return *std::max_element(weights.begin(), weights.end()) * static_cast<double>(weights.size()) / sum - 1;
}

}  // namespace

TEST_CASE("targets do not depend on blocks, ranks or threads") {
  for (const bool weighted : {false, true}) {
    const Cloud cloud = make_cloud(200000, weighted, 5);
    for (const Method method : kMethods) {
      const auto expected = targets_of(cloud, method, 13);
      CHECK(targets_of(cloud, method, 13, 1, 7, 2) == expected);
      CHECK(targets_of(cloud, method, 13, 3, 2, 2) == expected);
    }
  }
}

TEST_CASE("targets do not depend on the order of items") {
  Cloud cloud = make_cloud(5000, true, 6);
  for (const Method method : kMethods) {
    const auto expected = targets_of(cloud, method, 6);
    Cloud reversed = cloud;
    std::reverse(reversed.points.begin(), reversed.points.end());
    std::reverse(reversed.weights.begin(), reversed.weights.end());
    auto found = targets_of(reversed, method, 6);
    std::reverse(found.begin(), found.end());
    CHECK(found == expected);
  }
}

TEST_CASE("parts of a thousand items and more are even within one percent") {
  const std::vector<std::pair<std::size_t, std::uint32_t>> cases{{16000, 16}, {300000, 100}, {70001, 7}, {130000, 128}};
  for (const auto& [count, parts] : cases)
    for (const Method method : kMethods) {
      const Cloud cloud = make_cloud(count, false, 7);
      CHECK(imbalance(weight_by_target(cloud, targets_of(cloud, method, parts), parts)) < 0.01);
    }
}

TEST_CASE("weights are balanced, not counts") {
  Cloud cloud = make_cloud(100000, true, 8);
  for (std::size_t i = 0; i < cloud.points.size(); ++i)
    if (cloud.points[i].x > 0.5) cloud.weights[i] *= 20;
  for (const Method method : kMethods)
    CHECK(imbalance(weight_by_target(cloud, targets_of(cloud, method, 12), 12)) < 0.02);
}

TEST_CASE("items on few planes are told apart by their other coordinates") {
  Cloud cloud;
  for (int i = 0; i < 64; ++i)
    for (int j = 0; j < 64; ++j)
      for (int k = 0; k < 3; ++k)
        cloud.points.push_back({static_cast<float>(i % 2), static_cast<float>(j), static_cast<float>(k + 3 * i)});
  for (const Method method : kMethods)
    CHECK(imbalance(weight_by_target(cloud, targets_of(cloud, method, 16), 16)) < 0.01);
}

TEST_CASE("more parts than items leave parts empty and no item out") {
  for (const Method method : kMethods) {
    const Cloud cloud = make_cloud(10, false, 9);
    const auto weights = weight_by_target(cloud, targets_of(cloud, method, 1000, 2), 1000);
    CHECK(*std::max_element(weights.begin(), weights.end()) == 1);
    CHECK(targets_of(make_cloud(1, true, 1), method, 5).at(0) < 5);
    CHECK(targets_of({}, method, 5).empty());
    CHECK(targets_of(cloud, method, 1) == std::vector<std::uint32_t>(10, 0));
  }
}

TEST_CASE("items at one place get one target") {
  for (const Method method : kMethods) {
    const Cloud cloud{std::vector<Point3f>(1000, {1, 2, 3}), {}};
    const auto targets = targets_of(cloud, method, 8);
    CHECK(targets == std::vector<std::uint32_t>(1000, targets[0]));
  }
}

TEST_CASE("many parts of few items each are even to the item") {
  const Cloud cloud = make_cloud(100000, false, 11);
  for (const Method method : kMethods) {
    const auto weights = weight_by_target(cloud, targets_of(cloud, method, 16384, 1, 1, 2), 16384);
    CHECK(*std::max_element(weights.begin(), weights.end()) <= 7);
  }
}

TEST_CASE("blocks that are split on their own get targets of their own range, whatever the other blocks") {
  const Cloud cloud = make_cloud(30000, true, 10);
  const TaskRunner runner(2);
  std::vector<std::uint32_t> together(30000), alone(10000);
  std::vector<ItemBlock> blocks;
  std::vector<TargetRange> ranges;
  for (std::size_t b = 0; b < 3; ++b) {
    blocks.push_back({std::span(cloud.points).subspan(10000 * b, 10000),
                      std::span(cloud.weights).subspan(10000 * b, 10000),
                      std::span(together).subspan(10000 * b, 10000)});
    ranges.push_back({static_cast<std::uint32_t>(100 * b), 10});
  }
  for (const bool curve : {false, true}) {
    const auto split = [&](std::span<const ItemBlock> some, std::span<const TargetRange> into) {
      curve ? split_blocks_sfc(some, into, runner) : split_blocks_rcb(some, into, runner);
    };
    split(blocks, ranges);
    for (std::size_t i = 0; i < together.size(); ++i) REQUIRE(together[i] - 100 * (i / 10000) < 10);
    split(std::vector<ItemBlock>{{blocks[1].points, blocks[1].weights, alone}}, std::vector<TargetRange>{ranges[1]});
    CHECK(std::equal(alone.begin(), alone.end(), together.begin() + 10000));
  }
  CHECK_THROWS_AS(split_blocks_rcb(blocks, std::span(ranges).first(2), runner), Error);
}

TEST_CASE("bad weights and places are refused on every rank") {
  const double nan = std::numeric_limits<double>::quiet_NaN(), infinity = std::numeric_limits<double>::infinity();
  for (const Method method : kMethods) {
    for (const double bad : {0.0, -1.0, nan, infinity}) {
      std::array<bool, 2> refused{};
      on_simulated_ranks(2, [&](Communicator& communicator) {
        Cloud cloud = make_cloud(100, true, 12);
        if (communicator.rank() == 1) cloud.weights[50] = bad;
        std::vector<std::uint32_t> targets(100);
        const std::vector<ItemBlock> blocks{{cloud.points, cloud.weights, targets}};
        try {
          partition(method, blocks, 4, communicator, TaskRunner(1));
        } catch (const Error& error) {
          refused[communicator.rank()] = error.code() == ErrorCode::InvalidArgument;
        }
      });
      CHECK(refused == std::array{true, true});
    }
    Cloud cloud = make_cloud(100, false, 12);
    cloud.points[3].y = static_cast<float>(nan);
    CHECK_THROWS_AS(targets_of(cloud, method, 4), Error);
    CHECK_THROWS_AS(targets_of(make_cloud(100, false, 12), method, 0), Error);
  }
}

TEST_CASE("neighbours along the curve share a face") {
  constexpr int kSide = 16;
  const std::int64_t origin = (std::int64_t{1} << 20);
  std::vector<std::array<int, 3>> by_key(kSide * kSide * kSide);
  const std::uint64_t first = hilbert_key(origin, origin, origin) & ~std::uint64_t{kSide * kSide * kSide - 1};
  for (int x = 0; x < kSide; ++x)
    for (int y = 0; y < kSide; ++y)
      for (int z = 0; z < kSide; ++z) by_key.at(hilbert_key(origin + x, origin + y, origin + z) - first) = {x, y, z};
  for (std::size_t i = 1; i < by_key.size(); ++i) {
    int apart = 0;
    for (int axis = 0; axis < 3; ++axis) apart += std::abs(by_key[i][axis] - by_key[i - 1][axis]);
    REQUIRE(apart == 1);
  }
}

TEST_CASE("a cell lies in the piece of a cut curve that its key tells") {
  std::mt19937_64 random(31);
  const auto coordinate = [&](int bits) {
    return static_cast<std::int64_t>(random() >> (64 - bits)) << (kHilbertBits - bits);
  };
  for (const std::size_t count : {0u, 1u, 2u, 3u, 65u}) {
    CAPTURE(count);
    for (int i = 0; i < 2000; ++i) {
      // Few bits, so that cells are cuts themselves, which may be repeated.
      const int bits = 1 + i % kHilbertBits;
      std::vector<std::uint64_t> cuts(count);
      for (std::uint64_t& cut : cuts) cut = hilbert_key(coordinate(bits), coordinate(bits), coordinate(bits));
      std::sort(cuts.begin(), cuts.end());
      const std::int64_t x = coordinate(bits), y = coordinate(bits), z = coordinate(bits);
      const auto expected = std::upper_bound(cuts.begin(), cuts.end(), hilbert_key(x, y, z)) - cuts.begin();
      REQUIRE(hilbert_piece(x, y, z, cuts) == static_cast<std::size_t>(expected));
    }
  }
}
