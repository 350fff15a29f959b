#pragma once
// A bounding-volume hierarchy over boxes: what nearest places and rays are looked for in.
#include <array>
#include <cstdint>
#include <span>
#include <vector>

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

/// Splits at the median of the centres along their longest extent. The result does not depend on the thread count.
/// Complexity: O(n log n), in parallel.
Bvh build_bvh(std::span<const Box3> boxes, const BlockLoop& loop);

/// Visits items whose leaf overlaps `box`, in the order of the tree, until `test` is true of one; whether it was.
/// O(log n + leaves met).
template <class Test>
bool any_near(const Bvh& bvh, const Box3& box, const Test& test) {
  if (bvh.nodes.empty()) return false;
  std::array<std::uint32_t, 64> stack{0};
  for (std::size_t count = 1; count > 0;) {
    const std::uint32_t index = stack[--count];
    const BvhNode& node = bvh.nodes[index];
    if (!node.box.overlaps(box)) continue;
    if (node.right != 0) {
      stack[count++] = node.right;
      stack[count++] = index + 1;
      continue;
    }
    for (std::uint32_t i = node.begin; i < node.end; ++i)
      if (test(bvh.order[i])) return true;
  }
  return false;
}

/// Visits every item whose leaf overlaps `box`, in the order of the tree. O(log n + leaves met).
template <class Visit>
void for_each_near(const Bvh& bvh, const Box3& box, const Visit& visit) {
  any_near(bvh, box, [&](std::uint32_t item) {
    visit(item);
    return false;
  });
}

}  // namespace tetloom
