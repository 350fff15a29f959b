#include "core/spatial/bvh.hpp"

#include <algorithm>
#include <numeric>
#include <utility>

namespace tetloom {
namespace {

/// Median splits fall between whole leaves, so a range's size alone says how many nodes it needs, and disjoint subtrees
/// can be built at the same time.
class BvhBuilder {
 public:
  BvhBuilder(std::span<const Box3> boxes, Bvh& bvh) : boxes_(boxes), bvh_(bvh) {}

  struct Range {
    std::uint32_t node, begin, end;
  };

  /// Fills the node of a range; returns the ranges of its children, none for a leaf.
  std::vector<Range> split(const Range& range) {
    BvhNode& node = bvh_.nodes[range.node];
    Box3 centers;
    for (std::uint32_t i = range.begin; i < range.end; ++i) {
      node.box.add(boxes_[bvh_.order[i]]);
      centers.add(boxes_[bvh_.order[i]].center());
    }
    node.begin = range.begin;
    node.end = range.end;
    const std::uint32_t leaves = leaf_count(range.end - range.begin);
    if (leaves == 1) return {};
    const std::uint32_t left_leaves = leaves / 2;
    const std::uint32_t middle = range.begin + left_leaves * static_cast<std::uint32_t>(Bvh::kLeafItems);
    const Vec3 extent = centers.hi - centers.lo;
    const int axis = extent.x >= extent.y && extent.x >= extent.z ? 0 : extent.y >= extent.z ? 1 : 2;
    const auto first = bvh_.order.begin();
    std::nth_element(first + range.begin, first + middle, first + range.end, [&](std::uint32_t a, std::uint32_t b) {
      const double ca = boxes_[a].lo[axis] + boxes_[a].hi[axis], cb = boxes_[b].lo[axis] + boxes_[b].hi[axis];
      return ca != cb ? ca < cb : a < b;
    });
    node.right = range.node + 2 * left_leaves;
    return {{range.node + 1, range.begin, middle}, {node.right, middle, range.end}};
  }

  void build(const Range& range) {
    for (const Range& child : split(range)) build(child);
  }

  static std::uint32_t leaf_count(std::size_t items) {
    return static_cast<std::uint32_t>((items + Bvh::kLeafItems - 1) / Bvh::kLeafItems);
  }

 private:
  std::span<const Box3> boxes_;
  Bvh& bvh_;
};

}  // namespace

Bvh build_bvh(std::span<const Box3> boxes, const BlockLoop& loop) {
  Bvh bvh;
  if (boxes.empty()) return bvh;
  bvh.order.resize(boxes.size());
  std::iota(bvh.order.begin(), bvh.order.end(), 0u);
  bvh.nodes.resize(2 * std::size_t{BvhBuilder::leaf_count(boxes.size())} - 1);
  BvhBuilder builder(boxes, bvh);
  std::vector<BvhBuilder::Range> ranges{{0, 0, static_cast<std::uint32_t>(boxes.size())}};
  constexpr std::size_t kSubtrees = 64, kSmall = 4096;
  while (!ranges.empty() && ranges.size() < kSubtrees && ranges.front().end - ranges.front().begin > kSmall) {
    std::vector<std::vector<BvhBuilder::Range>> children(ranges.size());
    loop.for_blocks(ranges.size(), 1, [&](std::size_t i, std::size_t) { children[i] = builder.split(ranges[i]); });
    std::vector<BvhBuilder::Range> next;
    for (const auto& list : children) next.insert(next.end(), list.begin(), list.end());
    ranges = std::move(next);
  }
  loop.for_blocks(ranges.size(), 1, [&](std::size_t i, std::size_t) { builder.build(ranges[i]); });
  return bvh;
}

}  // namespace tetloom
