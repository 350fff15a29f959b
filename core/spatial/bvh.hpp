#pragma once
// A bounding-volume hierarchy over boxes: what nearest places and rays are looked for in.
#include <array>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "core/spatial/distances.hpp"
#include "tetloom/host.hpp"
#include "tetloom/vec.hpp"

namespace tetloom {

/// A box around some items, or around two nodes.
struct BvhNode {
  Box3 box;
  std::uint32_t begin = 0, end = 0;  ///< the items below, as positions in Bvh::order
  std::uint32_t right = 0;           ///< index of the second child, the first one follows its parent; 0: a leaf
};

/// Nodes in depth-first order. Leaves hold at most kLeafItems items.
struct Bvh {
  static constexpr std::size_t kLeafItems = 4;
  std::vector<BvhNode> nodes;
  std::vector<std::uint32_t> order;  ///< item indices, so that every node's items are contiguous
};

/// The same wherever it lies.
struct BvhView {
  BvhView(const Bvh& bvh) : nodes(bvh.nodes), order(bvh.order) {}
  BvhView(std::span<const BvhNode> given_nodes, std::span<const std::uint32_t> given_order)
      : nodes(given_nodes), order(given_order) {}

  std::span<const BvhNode> nodes;
  std::span<const std::uint32_t> order;
};

/// Of stacks that walk a tree: halving 2^32 items takes 32 levels, and each leaves one node waiting.
constexpr std::size_t kBvhDepth = 64;

/// Splits at the median of the centres along their longest extent. The result does not depend on the thread count.
/// Complexity: O(n log n), in parallel.
Bvh build_bvh(std::span<const Box3> boxes, const BlockLoop& loop);

/// Goes through the leaves below nodes whose boxes `enter` lets through, in the order of the tree, until `test` is true
/// of one of their positions in Bvh::order; whether it was.
template <class Enter, class Test>
bool any_entered(BvhView bvh, const Enter& enter, const Test& test) {
  if (bvh.nodes.empty()) return false;
  std::array<std::uint32_t, kBvhDepth> stack{0};
  for (std::size_t count = 1; count > 0;) {
    const std::uint32_t index = stack[--count];
    const BvhNode& node = bvh.nodes[index];
    if (!enter(node.box)) continue;
    if (node.right != 0) {
      stack[count++] = node.right;
      stack[count++] = index + 1;
      continue;
    }
    for (std::uint32_t i = node.begin; i < node.end; ++i)
      if (test(i)) return true;
  }
  return false;
}

/// Visits items whose leaf overlaps `box`, in the order of the tree, until `test` is true of one; whether it was.
/// O(log n + leaves met).
template <class Test>
bool any_near(BvhView bvh, const Box3& box, const Test& test) {
  return any_entered(
      bvh, [&](const Box3& node) { return node.overlaps(box); },
      [&](std::uint32_t position) { return test(bvh.order[position]); });
}

/// Visits every item whose leaf overlaps `box`, in the order of the tree. O(log n + leaves met).
template <class Visit>
void for_each_near(BvhView bvh, const Box3& box, const Visit& visit) {
  any_near(bvh, box, [&](std::uint32_t item) {
    visit(item);
    return false;
  });
}

/// Calls visit(position in Bvh::order) for the items of leaves that are not farther from `x` than reach2(), squared,
/// which may become smaller meanwhile; of two children the nearer one first.
template <class Reach, class Visit>
void visit_nearest_first(BvhView bvh, const Vec3& x, const Reach& reach2, const Visit& visit) {
  struct Entry {
    std::uint32_t node;
    double distance2;
  };
  if (bvh.nodes.empty()) return;
  const auto entry_of = [&](std::uint32_t node) {
    return Entry{node, squared_distance_to_box(x, bvh.nodes[node].box)};
  };
  std::array<Entry, kBvhDepth> stack;
  stack[0] = entry_of(0);
  for (std::size_t count = 1; count > 0;) {
    const Entry entry = stack[--count];
    if (entry.distance2 > reach2()) continue;
    const BvhNode& node = bvh.nodes[entry.node];
    if (node.right == 0) {
      for (std::uint32_t i = node.begin; i < node.end; ++i) visit(i);
      continue;
    }
    Entry near = entry_of(entry.node + 1), far = entry_of(node.right);
    if (far.distance2 < near.distance2) std::swap(near, far);
    stack[count++] = far;
    stack[count++] = near;
  }
}

}  // namespace tetloom
