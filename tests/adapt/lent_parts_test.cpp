// Parts that other ranks adapt.
#include "adapt/parts/lent_parts.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <numeric>

#include "tests/adapt/on_ranks.hpp"
#include "tests/adapt/one_round.hpp"
#include "tests/support/mixed_mesh.hpp"
#include "tetloom/adapt.hpp"

using namespace tetloom;
using namespace tetloom::adapt;
using namespace tetloom::test;

namespace {

std::vector<double> work_of_ranks(std::span<const PartLoad> loads, std::span<const int> to_rank, int ranks) {
  std::vector<double> sums(static_cast<std::size_t>(ranks), 0);
  for (std::size_t p = 0; p < loads.size(); ++p) {
    const int home = rank_of_part(static_cast<std::uint32_t>(p), loads.size(), ranks);
    sums[static_cast<std::size_t>(to_rank[p])] += loads[p].work;
    if (to_rank[p] == home) continue;
    sums[static_cast<std::size_t>(to_rank[p])] += loads[p].way, sums[static_cast<std::size_t>(home)] += loads[p].way;
  }
  return sums;
}

}  // namespace

TEST_CASE("parts go from ranks that have much to do to those that have little") {
  constexpr int kRanks = 4;
  std::vector<PartLoad> loads(80);
  for (std::size_t p = 0; p < loads.size(); ++p) loads[p] = {p < 20 ? 50.0 : 5.0, 0.5};
  const std::vector<int> to_rank = lend_parts(loads, kRanks);
  const std::vector<double> sums = work_of_ranks(loads, to_rank, kRanks);
  CHECK(std::ranges::max(sums) < 1.2 * std::accumulate(sums.begin(), sums.end(), 0.0) / kRanks);
  std::size_t lent = 0;
  for (std::uint32_t p = 0; p < 80; ++p) lent += to_rank[p] != rank_of_part(p, 80, kRanks) ? 1 : 0;
  CHECK(lent < 40);
}

TEST_CASE("parts stay where they are when there is nothing to gain") {
  const auto stay = [](const std::vector<PartLoad>& loads, int ranks) {
    const std::vector<int> to_rank = lend_parts(loads, ranks);
    for (std::uint32_t p = 0; p < loads.size(); ++p)
      if (to_rank[p] != rank_of_part(p, loads.size(), ranks)) return false;
    return to_rank.size() == loads.size();
  };
  CHECK(stay({}, 3));
  CHECK(stay({{5, 1}, {900, 1}}, 1));
  CHECK(stay(std::vector<PartLoad>(12, {10, 0}), 4));      // all alike
  CHECK(stay({{100, 1}, {1, 1}}, 2));                      // one part
  CHECK(stay({{10, 30}, {10, 30}, {1, 30}, {1, 30}}, 2));  // the way is too far
  CHECK_FALSE(stay({{10, 1}, {10, 1}, {1, 1}, {1, 1}}, 2));
}

TEST_CASE("work that differs little from part to part comes to be as much on all ranks") {
  constexpr int kRanks = 6;
  std::vector<PartLoad> loads;
  for (int p = 0; p < 300; ++p) loads.push_back({10.0 + 3 * std::sin(p / 40.0), 0.1});
  const std::vector<double> sums = work_of_ranks(loads, lend_parts(loads, kRanks), kRanks);
  CHECK(std::ranges::max(sums) < 1.05 * std::accumulate(sums.begin(), sums.end(), 0.0) / kRanks);
}

TEST_CASE("a part that was sent goes on as the one that stayed") {
  Mesh mesh = make_unit_cube(8);
  const MetricField metric =
      metric_from_function([](const Vec3& x) { return isotropic(0.06 + 0.2 * x.x); }, mesh.points);
  std::vector<std::vector<Vec3>> points;
  std::vector<std::vector<std::uint32_t>> tets;
  for (const bool is_sent : {false, true}) {
    in_one_round(mesh, metric, {}, 3, [&](CavityMesh& part, Passes& passes) {
      passes.split_edges(1.5), passes.collapse_edges(0.7, 1.45), passes.swap(0.6);
      if (is_sent) {
        MessageWriter writer;
        part.put(writer);
        const Bytes bytes = writer.take();
        MessageReader reader(bytes);
        part = CavityMesh::get(reader);
        CHECK(reader.at_end());
      }
      passes.split_edges(1.4), passes.swap(0.8), passes.smooth(0.92);
      points.emplace_back(part.mesh.points.begin(), part.mesh.points.end());
      tets.emplace_back(part.mesh.to_vert.begin(), part.mesh.to_vert.end());
    });
  }
  REQUIRE(points.size() == 6);
  for (std::size_t p = 0; p < 3; ++p) {
    CHECK(points[p] == points[p + 3]);
    CHECK(tets[p] == tets[p + 3]);
  }
}

TEST_CASE("a part has more to do where its edges do not fit") {
  const Mesh mesh = make_unit_cube(8);
  const auto work_at = [&](double size) {
    double sum = 0;
    in_one_round(mesh, metric_from_function([&](const Vec3&) { return isotropic(size); }, mesh.points), {}, 2,
                 [&](CavityMesh& part, Passes&) {
                   for (std::uint8_t& state : part.to_state) state = kHasChanged;
                   sum += load_of(part, 1.4).work;
                 });
    return sum;
  };
  const double fitting = work_at(0.16), fine = work_at(0.03), coarse = work_at(0.9);
  CHECK(fine > 5 * fitting);
  CHECK(coarse > 3 * fitting);
}
