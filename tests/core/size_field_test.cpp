// The immutable octree of sizes: reading, copies, the flat form, and what it refuses.
#include <catch2/catch.hpp>

#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <memory>
#include <random>
#include <span>
#include <vector>

#include "core/sizing/size_change.hpp"
#include "core/spatial/morton.hpp"
#include "tetloom/error.hpp"
#include "tetloom/size_field.hpp"

namespace tetloom {
namespace {

constexpr std::uint32_t kLeaf = SizeOctree::kLeafBit, kGlobal = SizeOctree::kGlobalLeaf;

const std::vector<std::array<float, 8>> kSmallTreeRatios{{0.125f, 1, 1, 1, 1, 1, 1, 1}, {1, 1, 1, 1, 1, 1, 1, 0.5f}};

/// The cube [0,8]³: octant 0 is cut again, its octant 0 has a corner of size 0.25 at the origin; all else is 2.
SizeOctree small_tree() {
  SizeOctree tree;
  tree.origin = {0, 0, 0};
  tree.width = 8;
  tree.domain = {{0, 0, 0}, {8, 8, 8}};
  tree.size = 2;
  tree.gradation = 0.5;
  tree.cells.assign(16, kGlobal);
  tree.cells[0] = 1;
  tree.cells[8] = kLeaf + 0;
  tree.cells[9] = kLeaf + 1;
  set_corner_ratios(tree, kSmallTreeRatios);
  return tree;
}

Vec3 random_point(std::mt19937_64& random, double reach) {
  std::uniform_real_distribution<double> coordinate(-reach, reach);
  return {coordinate(random), coordinate(random), coordinate(random)};
}

bool is_refused(const SizeOctree& tree) {
  try {
    SizeField::from_octree(tree);
  } catch (const Error& error) {
    return error.code() == ErrorCode::InvalidArgument;
  }
  return false;
}

}  // namespace

TEST_CASE("changes of a refined field are the leaves with other corners, and pieces of leaves") {
  const SizeField before = SizeField::from_octree(small_tree());
  CHECK(find_changes(before, before)->empty());
  SizeOctree lowered = small_tree();
  lowered.corner_ratios.back() = 0.25f;
  const auto one = find_changes(before, SizeField::from_octree(lowered));
  REQUIRE(one->size() == 1);
  CHECK(norm(one->front().lo - Vec3{2, 0, 0}) == 0);
  CHECK(norm(one->front().hi - Vec3{4, 2, 2}) == 0);
  SizeOctree cut = small_tree();
  cut.cells.insert(cut.cells.end(), 8, kGlobal);
  cut.cells[7] = 2;
  cut.cells[16] = kLeaf + static_cast<std::uint32_t>(cut.corner_ratios.size());
  cut.corner_ratios.insert(cut.corner_ratios.end(), {1, 1, 1, 1, 1, 1, 1, 0.5f});
  const auto corner = find_changes(before, SizeField::from_octree(cut));
  REQUIRE(corner->size() == 1);
  CHECK(norm(corner->front().lo - Vec3{4, 4, 4}) == 0);
  CHECK(norm(corner->front().hi - Vec3{6, 6, 6}) == 0);
  const auto back = find_changes(SizeField::from_octree(cut), before);  // sizes that vary less need fewer leaves
  REQUIRE(back->size() == 1);
  CHECK(norm(back->front().lo - Vec3{4, 4, 4}) == 0);
  CHECK(norm(back->front().hi - Vec3{8, 8, 8}) == 0);
  SizeOctree moved = small_tree();
  moved.origin = {-1, -1, -1};
  moved.width = 10;
  CHECK_FALSE(find_changes(before, SizeField::from_octree(moved)).has_value());
  CHECK_FALSE(find_changes(SizeField::uniform(2), before).has_value());
}

TEST_CASE("changes are found wherever the octree lies, though corners of its cells are rounded") {
  std::mt19937_64 random(7);
  for (int i = 0; i < 50; ++i) {
    SizeOctree tree = small_tree();
    tree.origin = random_point(random, 100);
    tree.width = std::abs(random_point(random, 10).x) + 0.1;
    tree.domain = {tree.origin, tree.origin + Vec3{tree.width, tree.width, tree.width}};
    SizeOctree cut = tree;
    cut.cells.insert(cut.cells.end(), 8, kGlobal);
    cut.cells[7] = 2;
    cut.cells[16] = kLeaf + static_cast<std::uint32_t>(cut.corner_ratios.size());
    cut.corner_ratios.insert(cut.corner_ratios.end(), {1, 1, 1, 1, 1, 1, 1, 0.5f});
    const SizeField before = SizeField::from_octree(tree), after = SizeField::from_octree(cut);
    REQUIRE(find_changes(before, after).has_value());
    CHECK(find_changes(before, after)->size() == 1);
    REQUIRE(find_changes(after, before).has_value());
    CHECK(find_changes(after, before)->size() == 1);
  }
}

TEST_CASE("a uniform field answers its size bit for bit in the whole space") {
  const double size = 0.1234567890123;
  const SizeField field = SizeField::uniform(size);
  std::mt19937_64 random(1);
  for (int i = 0; i < 1000; ++i) REQUIRE(field.size_at(random_point(random, 1e6)) == size);
  CHECK(field.size_at({std::numeric_limits<double>::quiet_NaN(), 0, 0}) == size);
  CHECK(field.smallest() == size);
  CHECK(field.largest() == size);
  CHECK(field.is_uniform());
  CHECK(field.leaf_count() == 1);
}

TEST_CASE("a uniform field of no size is refused") {
  for (const double size : {0.0, -1.0, std::nan(""), HUGE_VAL}) {
    INFO(size);
    CHECK_THROWS_AS(SizeField::uniform(size), Error);
  }
}

TEST_CASE("leaves are trilinear between their corners and exact where they are global") {
  const SizeField field = SizeField::from_octree(small_tree());
  CHECK(field.size_at({0, 0, 0}) == 0.25);
  CHECK(field.size_at({1, 0, 0}) == Approx(0.5 * (0.25 + 2)));
  CHECK(field.size_at({1, 1, 1}) == Approx(2 - 1.75 / 8));
  CHECK(field.size_at({2, 0, 0}) == 2);
  CHECK(field.size_at({4 - 1e-12, 2 - 1e-12, 2 - 1e-12}) == Approx(1));
  CHECK(field.size_at({3, 3, 3}) == 2);
  CHECK(field.size_at({7.9, 0.1, 5}) == 2);
  CHECK(field.smallest() == 0.25);
  CHECK(field.largest() == 2);
  CHECK(field.leaf_count() == 15);
}

TEST_CASE("a field whose arrays are kept elsewhere answers as before, for as long as somebody holds it") {
  const SizeField field = SizeField::from_octree(small_tree());
  std::vector<std::weak_ptr<const std::byte>> kept;
  {
    SizeField moved = SizeField::uniform(1);
    {
      const SizeField first = field.kept_by([&](std::span<const std::byte> bytes) -> std::shared_ptr<const std::byte> {
        if (kept.size() == 2) return nullptr;  // the last array stays
        const auto copy = std::make_shared<std::vector<std::byte>>(bytes.begin(), bytes.end());
        const std::shared_ptr<const std::byte> first_byte(copy, copy->data());
        kept.push_back(first_byte);
        return first_byte;
      });
      moved = first;
    }
    REQUIRE(kept.size() == 2);
    CHECK(!kept[0].expired());
    CHECK(!kept[1].expired());
    CHECK(moved.memory() == field.memory());
    std::mt19937_64 random(3);
    for (int i = 0; i < 1000; ++i) {
      const Vec3 x = random_point(random, 10);
      REQUIRE(moved.size_at(x) == field.size_at(x));
    }
    CHECK(moved.smallest() == field.smallest());
  }
  CHECK(kept[0].expired());
  CHECK(kept[1].expired());
  int asked = 0;
  const SizeField uniform = SizeField::uniform(3).kept_by([&](std::span<const std::byte>) {
    ++asked;
    return nullptr;
  });
  CHECK(asked == 0);
  CHECK(uniform.size_at({1, 2, 3}) == 3);
}

TEST_CASE("outside of its domain a field grows by the gradation up to the global size") {
  const SizeField field = SizeField::from_octree(small_tree());
  CHECK(field.size_at({-1, 0, 0}) == Approx(0.25 + 0.5));
  CHECK(field.size_at({-3, -4, 0}) == 2);
  CHECK(field.size_at({-1e300, 0, 0}) == 2);
  CHECK(field.size_at({-HUGE_VAL, 0, 0}) == 2);
  CHECK(field.size_at({100, 100, 100}) == 2);
  CHECK(std::isfinite(field.size_at({std::nan(""), std::nan(""), std::nan("")})));
}

TEST_CASE("leaves tile a box and carry the sizes at their centres") {
  const SizeField field = SizeField::from_octree(small_tree());
  double volume = 0;
  std::size_t count = 0;
  field.for_each_leaf({{0, 0, 0}, {8, 8, 8}}, [&](const SizeLeaf& leaf) {
    const Vec3 extent = leaf.box.hi - leaf.box.lo;
    volume += extent.x * extent.y * extent.z;
    CHECK(leaf.size == Approx(field.size_at(leaf.box.center())));
    ++count;
  });
  CHECK(volume == Approx(512));
  CHECK(count == field.leaf_count());
  CHECK(field.estimate_tets({{4, 4, 4}, {8, 8, 8}}) == Approx(kTetsPerCube * 64 / 8));
  CHECK(SizeField::uniform(0.5).estimate_tets({{0, 0, 0}, {1, 1, 1}}) == Approx(kTetsPerCube * 8));
}

TEST_CASE("trees that break an invariant are refused") {
  const SizeOctree good = small_tree();
  REQUIRE(validate_octree(good).empty());
  const auto broken = [&](const auto& change) {
    SizeOctree tree = good;
    change(tree);
    return tree;
  };
  const std::vector<SizeOctree> trees = {broken([](SizeOctree& t) { t.size = 0; }),
                                         broken([](SizeOctree& t) { t.size = HUGE_VAL; }),
                                         broken([](SizeOctree& t) { t.gradation = -1; }),
                                         broken([](SizeOctree& t) { t.width = std::nan(""); }),
                                         broken([](SizeOctree& t) { t.origin.y = HUGE_VAL; }),
                                         broken([](SizeOctree& t) { t.domain = {}; }),
                                         broken([](SizeOctree& t) { t.domain.hi.x = 9; }),
                                         broken([](SizeOctree& t) { t.cells.clear(); }),
                                         broken([](SizeOctree& t) { t.cells.pop_back(); }),
                                         broken([](SizeOctree& t) { t.cells[0] = 0; }),           // its own parent
                                         broken([](SizeOctree& t) { t.cells[0] = 2; }),           // beyond the end
                                         broken([](SizeOctree& t) { t.cells[1] = 1; }),           // two parents
                                         broken([](SizeOctree& t) { t.cells[0] = kGlobal; }),     // no parent
                                         broken([](SizeOctree& t) { t.cells[10] = kLeaf + 1; }),  // another beginning
                                         broken([](SizeOctree& t) { t.cells[9] = kGlobal; }),     // unused ratios
                                         broken([](SizeOctree& t) { t.cells[9] = kLeaf + 2; }),   // another beginning
                                         broken([](SizeOctree& t) { t.cells[12] = kLeaf; }),      // ratios are missing
                                         broken([](SizeOctree& t) { t.corner_ratios.pop_back(); }),
                                         broken([](SizeOctree& t) { t.corner_ratios[3] = 0; }),
                                         broken([](SizeOctree& t) { t.corner_ratios[3] = 1.5f; }),
                                         broken([](SizeOctree& t) { t.corner_ratios[3] = std::nanf(""); })};
  for (std::size_t i = 0; i < trees.size(); ++i) {
    INFO("broken tree " << i);
    CHECK(is_refused(trees[i]));
  }
}

TEST_CASE("leaves of a block have their common corners once, the smaller size of two, and none is without") {
  SizeOctree tree = small_tree();
  CHECK(tree.corner_ratios.size() == 12);
  tree.cells.resize(8);
  for (std::uint32_t octant = 0; octant < 8; ++octant) tree.cells[octant] = kLeaf + octant;
  std::vector<std::array<float, 8>> leaf_to_ratios(8);
  for (std::size_t octant = 0; octant < 8; ++octant)
    for (std::size_t corner = 0; corner < 8; ++corner)
      leaf_to_ratios[octant][corner] = static_cast<float>(1 + octant + 8 * corner) / 64;
  CHECK_THROWS_AS(set_corner_ratios(tree, std::span(leaf_to_ratios).first(7)), Error);
  set_corner_ratios(tree, leaf_to_ratios);
  REQUIRE(validate_octree(tree).empty());
  CHECK(tree.corner_ratios.size() == 27);
  const SizeField field = SizeField::from_octree(tree);
  CHECK(field.size_at({0, 0, 0}) == 2 * leaf_to_ratios[0][0]);
  CHECK(field.size_at({8, 0, 8}) == 2 * leaf_to_ratios[5][5]);
  CHECK(field.size_at({4, 4, 4}) == 2 * leaf_to_ratios[7][0]);
  CHECK(field.size_at({4, 0, 0}) == 2 * leaf_to_ratios[1][0]);
}

TEST_CASE("a tree deeper than the coordinates can tell apart is refused") {
  SizeOctree tree = small_tree();
  tree.corner_ratios.clear();
  const std::size_t blocks = SizeOctree::kMaxDepth + 1;
  tree.cells.assign(8 * blocks, kGlobal);
  for (std::size_t b = 0; b + 1 < blocks; ++b) tree.cells[8 * b] = static_cast<std::uint32_t>(b + 1);
  CHECK(is_refused(tree));
  tree.cells.resize(8 * (blocks - 1));
  tree.cells[8 * (blocks - 2)] = kGlobal;
  CHECK(validate_octree(tree).empty());
  CHECK(SizeField::from_octree(tree).size_at({0, 0, 0}) == 2);
}

TEST_CASE("copies of a field share it") {
  const SizeField field = SizeField::from_octree(small_tree());
  const SizeField copy = field;
  std::mt19937_64 random(2);
  for (int i = 0; i < 1000; ++i) {
    const Vec3 x = random_point(random, 10);
    REQUIRE(copy.size_at(x) == field.size_at(x));
  }
  CHECK(copy.memory() == field.memory());
  CHECK(copy.smallest() == field.smallest());
}

TEST_CASE("Morton codes are undone and order the octants depth first") {
  std::mt19937_64 random(4);
  for (int i = 0; i < 1000; ++i) {
    const std::array<std::uint32_t, 3> c{static_cast<std::uint32_t>(random() & 0x1fffff),
                                         static_cast<std::uint32_t>(random() & 0x1fffff),
                                         static_cast<std::uint32_t>(random() & 0x1fffff)};
    REQUIRE(morton_decode(morton_encode(c)) == c);
  }
  CHECK(morton_encode({1, 0, 0}) == 1);
  CHECK(morton_encode({0, 1, 0}) == 2);
  CHECK(morton_encode({0, 0, 1}) == 4);
  CHECK(morton_encode({2, 1, 1}) == 8 + 6);
}

}  // namespace tetloom
