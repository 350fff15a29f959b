// Edges between parts, which all parts that have them split alike.
#include <algorithm>
#include <catch2/catch.hpp>
#include <set>

#include "adapt/parts/cut_parts.hpp"
#include "adapt/parts/umbrellas.hpp"
#include "tests/adapt/kept_mesh.hpp"
#include "tests/adapt/meshed.hpp"
#include "tests/adapt/one_round.hpp"
#include "tests/adapt/touching_blocks.hpp"
#include "tests/adapt/uniform_metric.hpp"
#include "tests/support/mixed_mesh.hpp"
#include "tetloom/check.hpp"
#include "tetloom/tasks.hpp"

using namespace tetloom;
using namespace tetloom::adapt;

namespace {

constexpr int kCubes = 5;
constexpr double kSide = 1.0 / kCubes;

Mesh cube_in_cubes(bool two_regions) {
  test::BoxSpec spec{kCubes, kCubes, kCubes, two_regions, 1};
  spec.h = kSide;
  return test::make_tet_box(spec);
}

/// Diagonals of squares are longer than 1.3, sides are not.
MetricField metric_of(const Mesh& mesh) { return test::uniform_metric(mesh, kSide); }

/// A round in which nothing is done but at sides.
Mesh with_sides_split(const Mesh& mesh, const SideSplitOptions& sides, std::size_t part_count, std::size_t& count) {
  test::BeforeRound before(mesh, metric_of(mesh));
  count = adapt_in_parts(before.whole, before.links, before.deal(part_count),
                         {[](std::size_t, CavityMesh&) {}, &before.stage, sides}, before.work);
  return make_mesh_of(before.whole, mesh, TaskRunner(1));
}

std::multiset<std::array<double, 3>> places_of(const Mesh& mesh) {
  std::multiset<std::array<double, 3>> places;
  for (const Vec3& x : mesh.points) places.insert({x.x, x.y, x.z});
  return places;
}

}  // namespace

TEST_CASE("edges between parts are split by all of them alike", "[side_splits]") {
  const bool two_regions = GENERATE(false, true);
  const std::size_t part_count = GENERATE(2u, 3u, 7u);
  CAPTURE(two_regions, part_count);
  const Mesh cube = cube_in_cubes(two_regions);
  std::size_t count = 0;
  const Mesh mesh = with_sides_split(cube, {.longest = 1.3}, part_count, count);
  CHECK(count > 0);
  // One vertex each, and none twice.
  CHECK(mesh.points.size() == cube.points.size() + count);
  const auto before = places_of(cube), after = places_of(mesh);
  CHECK(std::set(after.begin(), after.end()).size() == mesh.points.size());
  CHECK(std::ranges::includes(after, before));
  CHECK(mesh.tet_to_vert.size() > cube.tet_to_vert.size());
  CHECK(test::volume_of(mesh) == Approx(1));
  CHECK(validate_mesh(mesh).valid());
}

TEST_CASE("no edge between parts is split where one of them refuses", "[side_splits]") {
  const Mesh cube = cube_in_cubes(true);
  std::size_t count = 1;
  const Mesh mesh = with_sides_split(cube, {.longest = 1.3, .most_tets = 10}, 4, count);
  CHECK(count == 0);
  CHECK(places_of(mesh) == places_of(cube));
  CHECK(mesh.tet_to_vert.size() == cube.tet_to_vert.size());
}

TEST_CASE("edges between parts that are short enough stay, and so do all of a single part", "[side_splits]") {
  const Mesh cube = cube_in_cubes(false);
  std::size_t count = 1;
  CHECK(with_sides_split(cube, {.longest = 2}, 4, count).points.size() == cube.points.size());
  CHECK(count == 0);
  count = 1;
  CHECK(with_sides_split(cube, {.longest = 1.3}, 1, count).points.size() == cube.points.size());
  CHECK(count == 0);
}

TEST_CASE("where a model is followed, edges between parts are split inside of regions alone", "[side_splits]") {
  const Mesh cube = cube_in_cubes(true);
  std::size_t count = 0, all = 0;
  const Mesh kept = with_sides_split(cube, {.longest = 1.3, .follows_model = true}, 4, count);
  CHECK(count > 0);
  CHECK(kept.tri_to_vert.size() == cube.tri_to_vert.size());
  const Mesh mesh = with_sides_split(cube, {.longest = 1.3}, 4, all);
  CHECK(all > count);
  CHECK(mesh.tri_to_vert.size() > cube.tri_to_vert.size());
}

TEST_CASE("no tet has two edges that parts agree on at once", "[side_splits]") {
  const Mesh cube = cube_in_cubes(true);
  test::BeforeRound before(cube, metric_of(cube));
  Dealing dealing = before.deal(3);
  RoundShare share = move_tets(before.whole, before.links, std::move(dealing.to_part), 3, before.work);
  std::vector<PartOfWhole> parts = cut_parts(share, 0, 3, before.runner);
  std::size_t accepted = 0;
  for (PartOfWhole& part : parts) {
    part.mesh.start();
    const auto edges = SideSplits(part.mesh, part.to_whole.span(), before.stage, {.longest = 1.3}).find();
    REQUIRE(!edges.empty());
    CHECK(std::ranges::is_sorted(edges, {}, &SideEdge::names));
    std::vector<int> to_count(part.mesh.mesh.size(), 0);
    for (const SideEdge& edge : edges) {
      if (edge.refused) continue;
      ++accepted;
      for (std::uint32_t tet = 0; tet < to_count.size(); ++tet)
        to_count[tet] += part.mesh.corner_of(tet, edge.ends[0]) < 4 && part.mesh.corner_of(tet, edge.ends[1]) < 4;
    }
    CHECK(std::ranges::max(to_count) == 1);
  }
  CHECK(accepted > 0);
}

TEST_CASE("edges at which bodies touch are not split at sides", "[side_splits]") {
  std::size_t splits = 0;
  for (const TouchingShape& shape : kTouchingShapes) {
    CAPTURE(shape.name);
    const Mesh mesh = mesh_of(shape, 2);
    test::BeforeRound before(mesh, metric_of(mesh));
    const TouchingVerts touching = separate_umbrellas(before.whole, before.runner);
    before.links = take_share(before.whole);
    splits += adapt_in_parts(before.whole, before.links, before.deal(9),
                             {[](std::size_t, CavityMesh&) {}, &before.stage, {.longest = 0.1}}, before.work);
    join_umbrellas(before.whole, touching);
    test::check_kept(mesh, make_mesh_of(before.whole, mesh, TaskRunner(1)));
  }
  CHECK(splits > 100);
}
