#include "mesher/intersection/triangle_tree.hpp"

#include <bit>
#include <cmath>
#include <utility>

#include "core/predicates/predicates.hpp"
#include "core/spatial/distances.hpp"
#include "core/spatial/morton.hpp"
#include "tetloom/tasks.hpp"
#include "threading/comm/own_share.hpp"
#include "threading/comm/sort_on_ranks.hpp"

namespace tetloom::intersection {

namespace {

constexpr std::size_t kBlock = 1 << 12, kNodes = 1 << 14;
constexpr std::size_t kFew = 1 << 14;  // triangles that take no longer than the messages

// Sign of orient2d in the (x,y) plane, with x moved by (e, e^2) for an infinitesimal e; 0 only where u and v coincide
// in that plane.
int perturbed_side(const Vec3& u, const Vec3& v, const Vec3& x) {
  const int side = orient2d({u.x, u.y}, {v.x, v.y}, {x.x, x.y});
  if (side != 0) return side;
  if (u.y != v.y) return v.y < u.y ? 1 : -1;
  return v.x > u.x ? 1 : v.x < u.x ? -1 : 0;
}

// The coordinates in an order in which `up` is the last; turned, not mirrored.
Vec3 turned(const Vec3& x, int up) { return {x[(up + 1) % 3], x[(up + 2) % 3], x[up]}; }

int shortest_axis(const Box3& box) {
  const Vec3 extent = box.hi - box.lo;
  const int least = extent.x < extent.y ? 0 : 1;
  return extent[least] < extent.z ? least : 2;
}

}  // namespace

std::size_t TriangleTree::pieces(std::size_t triangles) { return (triangles + kBlock - 1) / kBlock; }

TriangleTree::TriangleTree(std::span<const Vec3> points, std::span<const std::array<std::uint32_t, 3>> tri_to_vert,
                           const SharedWork& ranks)
    : points_(points), tri_to_vert_(tri_to_vert) {
  const TaskRunner& runner = ranks.runner();
  const std::size_t count = tri_to_vert_.size();
  const SharedWork alone(runner), &work = count > kFew ? ranks : alone;
  std::vector<Box3> boxes(pieces(count));
  work.fill<Box3>(boxes, 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t piece = begin; piece < end; ++piece)
      for (std::size_t i = piece * kBlock; i < std::min(count, (piece + 1) * kBlock); ++i)
        boxes[piece].add(box_of(static_cast<std::uint32_t>(i)));
  });
  Box3 around;
  for (const Box3& box : boxes) around.add(box);
  order_ = FixedArray(sort_triangles(around, work));
  if (!around.empty()) {
    constexpr double kRounding = 4e-16;
    origin_ = around.center();
    for (int axis = 0; axis < 3; ++axis)
      rounding_ = std::max({rounding_, kRounding * std::abs(around.lo[axis]), kRounding * std::abs(around.hi[axis])});
    up_ = shortest_axis(around);
  }
  first_leaf_ = std::bit_ceil(std::max<std::size_t>(leaf_count(), 1));
  std::vector<Node> nodes(first_leaf_ + leaf_count());
  work.fill<Node>(std::span(nodes).subspan(first_leaf_), kBlock / kLeafSize, [&](std::size_t begin, std::size_t end) {
    for (std::size_t leaf = begin; leaf < end; ++leaf) nodes[first_leaf_ + leaf] = node_of(leaf_box(leaf));
  });
  // Level by level: the nodes of one are [width, 2 width).
  for (std::size_t width = first_leaf_ / 2; width > 0; width /= 2) {
    runner.for_blocks(width, kNodes, [&](std::size_t begin, std::size_t end) {
      for (std::size_t node = width + begin; node < width + end; ++node) {
        for (const std::size_t child : {2 * node, 2 * node + 1})
          if (child < nodes.size()) nodes[node].add(nodes[child]);
      }
    });
  }
  nodes_ = FixedArray(std::move(nodes));
}

void TriangleTree::move_arrays(const KeepBytes& keep) {
  order_.move_to(keep);
  nodes_.move_to(keep);
}

TriangleTree::Node TriangleTree::node_of(const Box3& box) const {
  const auto below = [&](double x) { return std::nextafter(static_cast<float>(x - rounding_), -HUGE_VALF); };
  Node node;
  for (int axis = 0; axis < 3; ++axis) {
    const auto a = static_cast<std::size_t>(axis);
    node.lo[a] = below(box.lo[axis] - origin_[axis]);
    node.hi[a] = -below(origin_[axis] - box.hi[axis]);
  }
  return node;
}

std::vector<std::uint32_t> TriangleTree::sort_triangles(const Box3& around, const SharedWork& work) const {
  struct Key {
    std::uint64_t code;
    std::uint32_t triangle;
    bool operator<(const Key& other) const {
      return code != other.code ? code < other.code : triangle < other.triangle;
    }
  };
  const double extent =
      std::max({around.hi.x - around.lo.x, around.hi.y - around.lo.y, around.hi.z - around.lo.z, 1e-300});
  const ItemRange own = own_share(tri_to_vert_.size(), work);
  std::vector<Key> keys;
  work.each([&] {
    keys.resize(own.size());
    work.runner().for_blocks(keys.size(), kBlock, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) {
        const auto triangle = static_cast<std::uint32_t>(own.first + i);
        keys[i] = {morton_of(box_of(triangle).center(), around.lo, kMostMorton / extent), triangle};
      }
    });
  });
  keys = sort_on_ranks(std::move(keys), work);
  const auto order_of = [&](std::vector<std::uint32_t>& order) {
    order.resize(keys.size());
    work.runner().for_blocks(keys.size(), kNodes, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) order[i] = keys[i].triangle;
    });
  };
  std::vector<std::uint32_t> order;
  if (work.rank_count() == 1) {
    order_of(order);
    return order;
  }
  const std::vector<Bytes> given = work.all_gather([&](MessageWriter& writer) {
    order_of(order);
    writer.put_array<std::uint32_t>(order);
  });
  work.each([&] { order = joined_lists<std::uint32_t>(given); });
  return order;
}

Box3 TriangleTree::box_of(std::uint32_t triangle) const {
  Box3 box;
  for (const std::uint32_t vertex : tri_to_vert_[triangle]) box.add(points_[vertex]);
  return box;
}

Box3 TriangleTree::leaf_box(std::size_t leaf) const {
  Box3 box;
  for (const std::uint32_t triangle : leaf_triangles(leaf)) box.add(box_of(triangle));
  return box;
}

bool TriangleTree::any_within(const Vec3& x, double radius) const {
  bool found = false;
  descend([&](const Box3& node) { return squared_distance_to_box(x, node) < radius * radius; },
          [&](std::uint32_t triangle) {
            const auto& [a, b, c] = tri_to_vert_[triangle];
            found = distance_to_triangle(x, points_[a], points_[b], points_[c]) < radius;
            return !found;
          });
  return found;
}

bool TriangleTree::may_meet(const Box3& box) const {
  bool found = false;
  descend_leaves([&](const Box3& node) { return node.overlaps(box); },
                 [&](std::size_t leaf) { return !(found = leaf_box(leaf).overlaps(box)); });
  return found;
}

// 1 when the ray crosses a triangle whose normal points up, -1 for down, 0 when it does not cross.
int TriangleTree::crossing_above(std::uint32_t triangle, const Vec3& x) const {
  const auto [a, b, c] = corners_of(triangle);
  const Vec3 start = turned(x, up_), ends[] = {turned(a, up_), turned(b, up_), turned(c, up_)};
  const int side = perturbed_side(ends[0], ends[1], start);
  if (side == 0 || perturbed_side(ends[1], ends[2], start) != side || perturbed_side(ends[2], ends[0], start) != side)
    return 0;
  // Seen from above the triangle turns as `side` says; x is below it when the volume has the opposite sign.
  return orient3d(a, b, c, x) == -side ? side : 0;
}

}  // namespace tetloom::intersection
