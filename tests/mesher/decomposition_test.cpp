// Space in boxes, one per part.
#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <optional>
#include <random>
#include <stdexcept>

#include "core/predicates/predicates.hpp"
#include "core/tets/find_triangles.hpp"
#include "mesher/parts/decomposition.hpp"
#include "mesher/parts/key_filter.hpp"
#include "mesher/parts/near_box.hpp"
#include "mesher/parts/own_points.hpp"
#include "mesher/parts/part_surface.hpp"
#include "mesher/volume/volume_mesher.hpp"
#include "tests/mesher/volume_surfaces.hpp"
#include "tetloom/tasks.hpp"
#include "threading/comm/simulated_ranks.hpp"

namespace tetloom::parts {
namespace {

using namespace volume_tests;

// A surface with the cells of its inside.
struct Cells {
  Surface surface;
  SizeField sizes;
  TaskRunner runner{2};
  std::optional<intersection::TriangleTree> tree;
  lattice::LatticeRequest request;
  std::optional<lattice::LatticeCells> cells;

  Cells(Surface from, SizeField of) : surface(std::move(from)), sizes(std::move(of)) {
    tree.emplace(surface.points, surface.tri_to_vert, runner);
    request.tree = &*tree, request.tri_to_sides = surface.tri_to_sides, request.sizes = &sizes;
    for (const Vec3& x : surface.points) request.box.add(x);
    cells.emplace(request, runner);
  }
  Cells(const Cells&) = delete;

  Decomposition cut(std::size_t parts) const { return {*cells, parts, runner}; }
  Vec3 any_point(std::mt19937_64& random, double margin) const {
    Vec3 x;
    for (int axis = 0; axis < 3; ++axis) {
      const double lo = request.box.lo[axis] - margin, hi = request.box.hi[axis] + margin;
      x[axis] = std::uniform_real_distribution<double>(lo, hi)(random);
    }
    return x;
  }
};

Surface ball(int levels) {
  return ball_surface(levels, {0, 0, 0}, 0, [](const Vec3&) { return 1.0; });
}

bool is_in(const Vec3& x, const Box3& box) {
  for (int axis = 0; axis < 3; ++axis)
    if (!(box.lo[axis] <= x[axis] && x[axis] < box.hi[axis])) return false;
  return true;
}

bool are_neighbors(const Decomposition& decomposition, PartId a, PartId b) {
  const auto list = decomposition.neighbors(a);
  return std::binary_search(list.begin(), list.end(), b);
}

// A boundary that is exactly at the point belongs to the upper box, as it does to the upper child.
void check_tiles(const Cells& cells, const Decomposition& decomposition) {
  std::mt19937_64 random(99);
  for (int i = 0; i < 2000; ++i) {
    Vec3 x = cells.any_point(random, 1);
    if (i % 4 == 0)
      x[i / 4 % 3] =
          decomposition.box(PartId(static_cast<std::uint32_t>(random() % decomposition.part_count()))).hi[i / 4 % 3];
    if (!is_finite(x)) continue;
    const PartId owner = decomposition.owner_of(x);
    REQUIRE(owner.value < decomposition.part_count());
    for (std::uint32_t p = 0; p < decomposition.part_count(); ++p)
      REQUIRE(is_in(x, decomposition.box(PartId(p))) == (owner == PartId(p)));
  }
}

}  // namespace

TEST_CASE("boxes of parts tile space: every point lies in that of its owner and in no other") {
  const Cells uniform(ball(3), SizeField::uniform(0.1)), graded(ball(3), growing_sizes(0.05, 0.2));
  for (const Cells* cells : {&uniform, &graded})
    for (const std::size_t parts : {1u, 2u, 3u, 7u, 64u}) check_tiles(*cells, cells->cut(parts));
}

TEST_CASE("parts of any number have the same work") {
  const Surface ring = voxel_surface({3, 3, 1}, 4, [](int i, int j, int) { return i == 1 && j == 1 ? kOutside : 0u; });
  const Cells uniform(ball(3), SizeField::uniform(0.1)), graded(ball(3), growing_sizes(0.05, 0.2)),
      hollow(ring, SizeField::uniform(0.1));
  for (const Cells* cells : {&uniform, &graded, &hollow}) {
    const double whole = cells->cut(1).work(PartId(0));
    REQUIRE(whole > 0);
    for (const std::size_t parts : {2u, 5u, 16u, 100u}) {
      const Decomposition decomposition = cells->cut(parts);
      REQUIRE(decomposition.part_count() == parts);
      double sum = 0;
      for (std::uint32_t p = 0; p < parts; ++p) {
        const double work = decomposition.work(PartId(p));
        CHECK(work * double(parts) == Approx(whole).epsilon(0.2));
        sum += work;
      }
      CHECK(sum == Approx(whole).epsilon(1e-9));
    }
  }
}

TEST_CASE("the number of tets is estimated within a fifth") {
  const Surface surface = ball(5);
  const SizeField sizes = SizeField::uniform(0.06);
  const Cells cells(surface, sizes);
  const VolumeMesh mesh = fill_volume(surface.input(sizes), {}, TaskRunner(2));
  CHECK(estimate_volume(*cells.cells).tets == Approx(double(mesh.tet_to_vert.size())).epsilon(0.2));
}

TEST_CASE("a part's cells are those that reach into its box") {
  const Cells cells(ball(3), growing_sizes(0.05, 0.2));
  const Decomposition decomposition = cells.cut(9);
  for (std::uint32_t p = 0; p < 9; ++p) {
    const Box3& box = decomposition.box(PartId(p));
    std::vector<std::uint32_t> expected;
    for (std::uint32_t c = 0; c < cells.cells->cells().size(); ++c) {
      const Box3& cell = cells.cells->cells()[c].box;
      bool reaches = true;
      for (int axis = 0; axis < 3; ++axis) reaches &= cell.lo[axis] < box.hi[axis] && cell.hi[axis] > box.lo[axis];
      if (reaches) expected.push_back(c);
    }
    const auto found = decomposition.cells_of(PartId(p));
    CHECK(std::vector<std::uint32_t>(found.begin(), found.end()) == expected);
  }
}

TEST_CASE("neighbours are so on both sides, and whoever has anything near is one") {
  const Cells uniform(ball(3), SizeField::uniform(0.02)), graded(ball(3), growing_sizes(0.02, 0.06));
  for (const Cells* cells : {&uniform, &graded}) {
    const Decomposition decomposition = cells->cut(40);
    std::size_t links = 0;
    for (std::uint32_t p = 0; p < 40; ++p) {
      CHECK_FALSE(are_neighbors(decomposition, PartId(p), PartId(p)));
      for (const PartId other : decomposition.neighbors(PartId(p)))
        CHECK(are_neighbors(decomposition, other, PartId(p)));
      links += decomposition.neighbors(PartId(p)).size();
    }
    CHECK(links < 40 * 39);
    std::mt19937_64 random(3);
    for (int i = 0; i < 3000; ++i) {
      const Vec3 x = cells->any_point(random, 0);
      if (!cells->cells->is_inside(x)) continue;
      const double reach = Decomposition::kNeighborhood * cells->sizes.size_at(x);
      std::uniform_real_distribution<double> step(-reach, reach);
      const PartId a = decomposition.owner_of(x);
      const PartId b = decomposition.owner_of(x + Vec3{step(random), step(random), step(random)});
      if (a != b) REQUIRE(are_neighbors(decomposition, a, b));
    }
  }
}

TEST_CASE("what is near a neighbour's box is told to that neighbour, and to no other") {
  const Cells cells(ball(3), SizeField::uniform(0.04));
  const Decomposition decomposition = cells.cut(12);
  std::mt19937_64 random(11);
  std::vector<Placed<int>> placed;
  for (int i = 0; i < 500; ++i) placed.push_back({cells.any_point(random, 0.1), 0.001 * i, i});
  for (std::uint32_t p = 0; p < 12; ++p) {
    const auto neighbors = decomposition.neighbors(PartId(p));
    const auto near = near_neighbors(placed, decomposition, PartId(p));
    REQUIRE(near.size() == neighbors.size());
    for (std::size_t n = 0; n < near.size(); ++n) {
      std::vector<int> expected;
      for (const Placed<int>& one : placed)
        if (distance_outside(one.place, decomposition.box(neighbors[n])) <= one.reach) expected.push_back(one.what);
      CHECK(near[n] == expected);
    }
  }
}

TEST_CASE("a part knows the triangles that meet its box, however large they are") {
  const double size = GENERATE(0.1, 0.02, 0.003);
  const Cells cells(ball(4), SizeField::uniform(0.1));
  const Decomposition decomposition = cells.cut(10);
  volume::Complex complex;
  complex.points = cells.surface.points;
  complex.tri_to_vert = cells.surface.tri_to_vert;
  const PartSurface surface(complex, SizeField::uniform(size), decomposition, 2, cells.runner);
  std::size_t met = 0;
  for (std::uint32_t p = 0; p < 10; ++p) {
    const auto known = surface.triangles_of(PartId(p));
    const auto points = surface.points_of(PartId(p));
    for (std::uint32_t t = 0; t < complex.tri_to_vert.size(); ++t) {
      const auto& [a, b, c] = complex.tri_to_vert[t];
      const Vec3 center = (complex.points[a] + complex.points[b] + complex.points[c]) / 3;
      if (!is_in(center, decomposition.box(PartId(p)))) continue;
      CHECK(std::binary_search(known.begin(), known.end(), t));
      for (const std::uint32_t v : {a, b, c}) CHECK(std::binary_search(points.begin(), points.end(), v));
      ++met;
    }
  }
  CHECK(met == complex.tri_to_vert.size());
}

TEST_CASE("cells of some parts may be kept while those of others are given up") {
  Cells cells(ball(3), growing_sizes(0.05, 0.2));
  Decomposition decomposition = cells.cut(7);
  const std::vector<PartId> kept{PartId(1u), PartId(4u)};
  const auto corners_of = [&](PartId part) {
    std::vector<double> corners;
    for (const std::uint32_t cell : decomposition.cells_of(part)) {
      const lattice::LatticeCell& one = cells.cells->cells()[cell];
      corners.insert(corners.end(), {one.box.lo.x, one.box.hi.y, one.box.hi.z, one.lo});
    }
    return corners;
  };
  std::vector<std::vector<double>> corners;
  for (const PartId part : kept) corners.push_back(corners_of(part));
  const std::size_t before = cells.cells->cells().size();
  cells.cells->keep(decomposition.keep_cells_of(kept));
  CHECK(cells.cells->cells().size() < before / 2);
  for (std::size_t i = 0; i < kept.size(); ++i) {
    CHECK_FALSE(corners[i].empty());
    CHECK(corners_of(kept[i]) == corners[i]);
  }
  CHECK(decomposition.cells_of(PartId(0u)).empty());
}

template <class T>
std::vector<T> list_of(std::span<const T> items) {
  return {items.begin(), items.end()};
}

TEST_CASE("ranks cut space as one process does, and know the same of the surface", "[ranks]") {
  const int ranks = GENERATE(2, 3, 12);
  constexpr std::size_t kParts = 9;
  const Cells cells(ball(5), growing_sizes(0.05, 0.2));  // more triangles than a rank takes alone
  const Decomposition whole = cells.cut(kParts);
  volume::Complex complex;
  complex.points = cells.surface.points;
  complex.tri_to_vert = cells.surface.tri_to_vert;
  const PartSurface known(complex, cells.sizes, whole, 2, cells.runner);
  std::vector<int> parts_seen(static_cast<std::size_t>(ranks), 0);
  on_simulated_ranks(ranks, [&](Communicator& communicator) {
    const SharedWork work(1, {}, &communicator);
    bool are_alike = true;
    work.together([&] {
      const lattice::LatticeCells own(cells.request, work);
      are_alike &= own.cells().size() == cells.cells->cells().size();
      const Decomposition cut(own, kParts, work);
      const PartSurface surface(complex, cells.sizes, cut, 2, work);
      for (std::uint32_t p = 0; p < kParts; ++p) {
        const PartId part(p);
        are_alike &= cut.work(part) == whole.work(part) && cut.box(part).lo == whole.box(part).lo &&
                     cut.box(part).hi == whole.box(part).hi &&
                     list_of(cut.neighbors(part)) == list_of(whole.neighbors(part));
      }
      for (std::uint32_t v = 0; v < complex.points.size(); ++v) are_alike &= surface.owner_of(v) == known.owner_of(v);
      for (const PartId part : communicator.parts_of_rank(kParts)) {
        ++parts_seen[static_cast<std::size_t>(communicator.rank())];
        are_alike &= list_of(cut.cells_of(part)) == list_of(whole.cells_of(part)) &&
                     list_of(surface.points_of(part)) == list_of(known.points_of(part)) &&
                     list_of(surface.triangles_of(part)) == list_of(known.triangles_of(part));
      }
    });
    if (!are_alike) throw std::logic_error("a rank has something else");
  });
  CHECK(std::accumulate(parts_seen.begin(), parts_seen.end(), 0) == kParts);
}

TEST_CASE("ranks find the open regions that one process finds", "[ranks]") {
  Surface surface = ball(4);
  surface.tri_to_vert.erase(surface.tri_to_vert.begin() + 17);
  surface.tri_to_sides.erase(surface.tri_to_sides.begin() + 17);
  const SizeField sizes = SizeField::uniform(0.1);
  const std::vector<std::uint32_t> faces(surface.tri_to_vert.size(), 0);
  VolumeInput input = surface.input(sizes);
  input.tri_to_face = faces;
  const volume::OpenRegions alone = volume::find_open_regions(input, TaskRunner(1));
  REQUIRE(alone.regions.size() == 1);
  std::vector<volume::OpenRegions> found(5);
  on_simulated_ranks(5, [&](Communicator& communicator) {
    const SharedWork work(1, {}, &communicator);
    work.together([&] { found[static_cast<std::size_t>(work.rank())] = volume::find_open_regions(input, work); });
  });
  for (const volume::OpenRegions& one : found) {
    CHECK(one.regions == alone.regions);
    REQUIRE(one.diagnostics.size() == 1);
    CHECK(one.diagnostics[0].message == alone.diagnostics[0].message);
    CHECK(one.diagnostics[0].elements == alone.diagnostics[0].elements);
  }
}

TEST_CASE("triangles are found by their vertices in any order, the first of equal ones") {
  const std::vector<tets::TriangleVerts> triangles{{4, 2, 3}, {0, 1, 2}, {2, 1, 0}, {1, 4, 0}, {3, 4, 2}};
  const tets::TrianglesByVertex index(triangles, 6);
  CHECK(index.find(tets::sorted({1, 2, 0})) == 1u);
  CHECK(index.find(tets::sorted({2, 3, 4})) == 0u);
  CHECK(index.find(tets::sorted({4, 1, 0})) == 3u);
  CHECK_FALSE(index.find(tets::sorted({0, 1, 3})).has_value());
  CHECK_FALSE(index.find(tets::sorted({5, 4, 3})).has_value());
}

TEST_CASE("what is said to be one part is no more by what is known later") {
  for (const double tets : {10.0, 1e3, 1e4, 1e5, 1e6})
    for (const std::size_t triangles : {4u, 1000u, 20000u, 100000u})
      for (const double per_part : {0.0, 1000.0, 1e5, HUGE_VAL}) {
        if (!is_one_part(tets, triangles, per_part)) continue;
        // Twice as many, where sizes vary everywhere.
        const double work = 2 * (31 / 9.5 * tets + 8.4 * static_cast<double>(triangles));
        CHECK(count_parts({2 * tets, work}, per_part) == 1);
      }
  CHECK(is_one_part(1e3, 500, 0));
  CHECK_FALSE(is_one_part(1e6, 500, 0));
  CHECK_FALSE(is_one_part(100, 100000, 0));
  CHECK(is_one_part(1e9, 1000, HUGE_VAL));
}

TEST_CASE("a volume is cut into an even number of parts by its work and its tets, and as asked") {
  CHECK(count_parts({0, 0}, 0) == 1);
  CHECK(count_parts({2e4, 2.3e5}, 0) == 1);
  CHECK(count_parts({2e4, 2.5e5}, 0) == 2);
  CHECK(count_parts({2e5, 5e4}, 0) == 2);
  CHECK(count_parts({1.7e5, 1.3e6}, 0) == 4);
  CHECK(count_parts({2e6, 1e7}, 0) == 26);
  CHECK(count_parts({2e7, 8e6}, 0) == 80);
  CHECK(count_parts({1e15, 0}, 0) == 100000);
  CHECK(count_parts({1e6, 1e7}, HUGE_VAL) == 1);
  CHECK(count_parts({1e6, 1e7}, 3e5) == 3);
  CHECK(count_parts({1e5, 1e7}, 3e5) == 1);
}

TEST_CASE("of an open ball a part is told the points on its sphere and the nearest ones inside of it") {
  std::mt19937_64 random(3);
  std::uniform_real_distribution<double> place(-1, 1);
  for (const std::size_t count : {0u, 1u, 12u, 13u, 700u}) {
    std::vector<ShellPoint> points;
    for (std::size_t i = 0; i < count; ++i) {
      points.push_back({{place(random), place(random), place(random)}, i * 7 % (count + 1), 0});
      if (i % 4 == 0) points.back().point = points.back().point / norm(points.back().point);
    }
    const OwnPoints own(points);
    // One of its corners is off the middle, so that nearest to the tet is not nearest to the sphere's centre.
    OpenBall ball{{Vec3{1, 0, 0}, Vec3{0, 1, 0}, Vec3{0, 0, 1}, Vec3{0.6, 0.8, 0}}, {}, 1 + 1e-9};
    if (orient3d(ball.corners[0], ball.corners[1], ball.corners[2], ball.corners[3]) < 0)
      std::swap(ball.corners[0], ball.corners[1]);
    const auto& [a, b, c, d] = ball.corners;
    const Vec3 middle = 0.25 * (a + b + c + d);
    std::vector<std::pair<double, std::uint64_t>> inside;
    std::size_t held = 0;
    for (const ShellPoint& point : points) {
      const int side = insphere(a, b, c, d, point.point);
      held += side >= 0;
      if (side > 0) inside.emplace_back(norm2(point.point - middle), point.key);
    }
    std::sort(inside.begin(), inside.end());
    const std::array open_balls{ball, ball};
    const auto all = own.find_in(open_balls, points.size() + 1);
    CHECK(all.size() == held);
    const auto by_key = [](const ShellPoint& s, const ShellPoint& t) { return s.key < t.key; };
    CHECK(std::is_sorted(all.begin(), all.end(), by_key));
    const auto few = own.find_in(open_balls, 3);
    CHECK(few.size() <= all.size());
    for (std::size_t i = 0; i < std::min<std::size_t>(3, inside.size()); ++i)
      CHECK(std::any_of(few.begin(), few.end(), [&](const ShellPoint& s) { return s.key == inside[i].second; }));
    std::size_t few_inside = 0;
    for (const ShellPoint& s : few) few_inside += insphere(a, b, c, d, s.point) > 0;
    CHECK(few_inside == std::min<std::size_t>(3, inside.size()));
  }
}

TEST_CASE("a filter of keys holds those that it was given, and few others") {
  for (const std::size_t count : {0u, 1u, 5u, 1000u}) {
    std::mt19937_64 random(count);
    std::vector<VertKey> keys;
    for (std::size_t i = 0; i < count; ++i) keys.push_back(random());
    const KeyFilter filter(keys);
    for (const VertKey key : keys) CHECK(filter.may_hold(key));
    int others = 0;
    for (int i = 0; i < 10000; ++i) others += filter.may_hold(random());
    CHECK(others < 2000);
  }
}

TEST_CASE("one part is all of space") {
  const Cells cells(ball(2), SizeField::uniform(0.2));
  const Decomposition decomposition = cells.cut(1);
  CHECK(decomposition.neighbors(PartId(0)).empty());
  CHECK(decomposition.cells_of(PartId(0)).size() == cells.cells->cells().size());
  CHECK(decomposition.box(PartId(0)).lo == Vec3(-HUGE_VAL, -HUGE_VAL, -HUGE_VAL));
  CHECK(decomposition.box(PartId(0)).hi == Vec3(HUGE_VAL, HUGE_VAL, HUGE_VAL));
}

TEST_CASE("where there are more parts than numbers to cut at, some are left without cells") {
  Surface cube = cube_surface(1);
  for (Vec3& x : cube.points) x += 0x1p51 * Vec3{1, 1, 1};  // numbers are halves there
  const Cells cells(cube, SizeField::uniform(1));
  const Decomposition decomposition = cells.cut(600);
  CHECK(decomposition.part_count() == 600);
  std::size_t empty = 0;
  for (std::uint32_t p = 0; p < 600; ++p) empty += decomposition.cells_of(PartId(p)).empty();
  CHECK(empty > 0);
  CHECK(empty < 600);
  check_tiles(cells, decomposition);
}

}  // namespace tetloom::parts
