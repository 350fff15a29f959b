// Distances from boxes, segments and triangles, and trees of boxes.
#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <functional>
#include <random>
#include <vector>

#include "core/spatial/along_axis.hpp"
#include "core/spatial/bvh.hpp"
#include "core/spatial/distances.hpp"
#include "tetloom/host.hpp"

namespace tetloom {
namespace {

Vec3 random_point(std::mt19937_64& random) {
  std::uniform_real_distribution<double> place(-1, 1);
  const double x = place(random), y = place(random);
  return {x, y, place(random)};
}

// The least distance to points of the triangle on a grid of barycentric coordinates.
double sampled_distance(const Vec3& x, const Vec3& a, const Vec3& b, const Vec3& c) {
  constexpr int kSteps = 60;
  double least = HUGE_VAL;
  for (int i = 0; i <= kSteps; ++i)
    for (int j = 0; i + j <= kSteps; ++j) {
      const double s = double(i) / kSteps, t = double(j) / kSteps;
      least = std::min(least, distance(x, (1 - s - t) * a + s * b + t * c));
    }
  return least;
}

TEST_CASE("the distance from a triangle is that of its nearest point") {
  std::mt19937_64 random(5);
  for (int i = 0; i < 200; ++i) {
    const Vec3 a = random_point(random), b = random_point(random), c = random_point(random);
    const Vec3 x = 2 * random_point(random);
    const double found = distance_to_triangle(x, a, b, c), sampled = sampled_distance(x, a, b, c);
    CHECK(found <= sampled + 1e-12);
    CHECK(found >= sampled - 0.05);
    CHECK(distance_to_triangle(a, a, b, c) == Approx(0).margin(1e-12));
    CHECK(distance_to_triangle((a + b + c) / 3, a, b, c) == Approx(0).margin(1e-12));
  }
}

TEST_CASE("triangles without area are segments or points") {
  const Vec3 a{0, 0, 0}, b{1, 0, 0}, c{3, 0, 0}, x{2, 1, 0};
  CHECK(distance_to_triangle(x, a, b, c) == Approx(1));
  CHECK(distance_to_triangle(x, c, a, b) == Approx(1));
  CHECK(distance_to_triangle(x, a, a, b) == Approx(std::sqrt(2.0)));
  CHECK(distance_to_triangle(x, a, a, a) == Approx(std::sqrt(5.0)));
  CHECK(distance_to_segment(x, b, b) == Approx(std::sqrt(2.0)));
  CHECK(squared_distance_to_segment(x, a, c) == Approx(1));
}

TEST_CASE("the distance from a box is 0 inside and on it, and infinite from an empty one") {
  const Box3 box{{0, 0, 0}, {1, 2, 3}};
  CHECK(squared_distance_to_box({0.5, 1, 3}, box) == 0);
  CHECK(squared_distance_to_box({2, 1, 1}, box) == 1);
  CHECK(squared_distance_to_box({2, 3, 5}, box) == 6);
  CHECK(squared_distance_to_box({0, 0, 0}, Box3{}) == HUGE_VAL);
}

// Blocks in the reverse order.
class ReversedLoop : public BlockLoop {
 public:
  void for_blocks(std::size_t count, std::size_t grain,
                  const std::function<void(std::size_t, std::size_t)>& body) const override {
    for (std::size_t begin = (count + grain - 1) / grain * grain; begin > 0; begin -= grain)
      body(begin - grain, std::min(count, begin));
  }
};

TEST_CASE("seen along the axis nearest to its normal, a triangle keeps its area and turns as the normal points") {
  std::mt19937_64 random(7);
  for (int i = 0; i < 200; ++i) {
    const Vec3 a = random_point(random), b = random_point(random), c = random_point(random);
    const Vec3 normal = cross(b - a, c - a);
    const int axis = nearest_axis(normal);
    const Vec2 p = without_axis(a, axis), q = without_axis(b, axis), r = without_axis(c, axis);
    CHECK(std::abs(normal[axis]) >= norm(normal) / std::sqrt(3.0) - 1e-12);
    CHECK(cross(q - p, r - p) == Approx(normal[axis]));
  }
  CHECK(nearest_axis({1, -1, 1}) == 0);
  CHECK(nearest_axis({1, -2, 2}) == 1);
}

TEST_CASE("a tree of boxes has every box once, below nodes that hold it, whoever builds it") {
  std::mt19937_64 random(6);
  for (const std::size_t count : {0u, 1u, 4u, 5u, 1000u, 20000u}) {
    std::vector<Box3> boxes(count);
    for (Box3& box : boxes) {
      const Vec3 x = random_point(random);
      box.add(x), box.add(x + 0.1 * random_point(random));
    }
    const Bvh bvh = build_bvh(boxes, serial_loop());
    std::vector<std::uint32_t> seen = bvh.order;
    std::sort(seen.begin(), seen.end());
    for (std::uint32_t i = 0; i < seen.size(); ++i) REQUIRE(seen[i] == i);
    CHECK(seen.size() == count);
    std::size_t in_leaves = 0;
    for (std::uint32_t n = 0; n < bvh.nodes.size(); ++n) {
      const BvhNode& node = bvh.nodes[n];
      for (std::uint32_t i = node.begin; i < node.end; ++i) {
        REQUIRE(node.box.contains(boxes[bvh.order[i]].lo));
        REQUIRE(node.box.contains(boxes[bvh.order[i]].hi));
      }
      if (node.right == 0) {
        REQUIRE(node.end - node.begin <= Bvh::kLeafItems);
        in_leaves += node.end - node.begin;
        continue;
      }
      REQUIRE(bvh.nodes[n + 1].begin == node.begin);
      REQUIRE(bvh.nodes[n + 1].end == bvh.nodes[node.right].begin);
      REQUIRE(bvh.nodes[node.right].end == node.end);
    }
    CHECK(in_leaves == count);
    CHECK(build_bvh(boxes, ReversedLoop()).order == bvh.order);
  }
}

}  // namespace
}  // namespace tetloom
