#include "core/sizing/size_change.hpp"

#include <algorithm>
#include <span>

namespace tetloom {
namespace {

std::vector<SizeLeaf> list_leaves(const SizeField& field) {
  constexpr double kFar = 1e300;
  std::vector<SizeLeaf> leaves;
  leaves.reserve(field.leaf_count());
  field.for_each_leaf({{-kFar, -kFar, -kFar}, {kFar, kFar, kFar}},
                      [&](const SizeLeaf& leaf) { leaves.push_back(leaf); });
  return leaves;
}

// Cells of one octree lie in each other or apart, but for rounding: corners of the same grid are computed in other ways
// at other depths.
bool contains(const Box3& outer, const Box3& inner) {
  constexpr double kSlack = 1e-3;  // of the inner one's extent
  const Vec3 slack = kSlack * (inner.hi - inner.lo);
  const Box3 wide{outer.lo - slack, outer.hi + slack};
  return wide.contains(inner.lo) && wide.contains(inner.hi);
}

// The leaves of one field in Morton order, the next one first.
struct LeafRow {
  std::vector<SizeLeaf> leaves;
  std::size_t next = 0;

  bool at_end() const { return next == leaves.size(); }
  const SizeLeaf& front() const { return leaves[next]; }
  std::span<const SizeLeaf> take_within(const Box3& box) {
    const std::size_t first = next;
    while (!at_end() && contains(box, front().box)) ++next;
    return std::span(leaves).subspan(first, next - first);
  }
};

}  // namespace

// Both rows are in Morton order, so that the pieces of a leaf follow each other. Corners only become smaller, so a
// leaf with the same size in its middle has the same corners. Where refined sizes vary less, a leaf of the new field is
// made of several of the old one.
std::optional<std::vector<Box3>> find_changes(const SizeField& before, const SizeField& after) {
  if (before.is_uniform() || after.is_uniform()) return std::nullopt;
  LeafRow olds{list_leaves(before)}, news{list_leaves(after)};
  std::vector<Box3> changes;
  while (!olds.at_end() && !news.at_end()) {
    const SizeLeaf old = olds.front(), fresh = news.front();
    const std::span<const SizeLeaf> pieces = news.take_within(old.box);
    if (pieces.empty()) {
      if (olds.take_within(fresh.box).empty()) return std::nullopt;
      changes.push_back(fresh.box);
      ++news.next;
      continue;
    }
    ++olds.next;
    for (const SizeLeaf& piece : pieces)
      if (piece.size != (pieces.size() > 1 ? before.size_at(piece.box.center()) : old.size))
        changes.push_back(piece.box);
  }
  if (!olds.at_end() || !news.at_end()) return std::nullopt;
  return changes;
}

bool has_same_sizes(const SizeField& sizes, const RigidMotion& motion, std::span<const Vec3> points) {
  constexpr double kMostApart = 1.2;
  return std::ranges::all_of(points, [&](const Vec3& p) {
    const double here = sizes.size_at(p), there = sizes.size_at(motion(p));
    return here <= kMostApart * there && there <= kMostApart * here;
  });
}

}  // namespace tetloom
