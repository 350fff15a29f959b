#include "core/sizing/size_change.hpp"

namespace tetloom {
namespace {

std::vector<SizeLeaf> list_leaves(const SizeField& field) {
  constexpr double kFar = 1e300;
  std::vector<SizeLeaf> leaves;
  field.for_each_leaf({{-kFar, -kFar, -kFar}, {kFar, kFar, kFar}},
                      [&](const SizeLeaf& leaf) { leaves.push_back(leaf); });
  return leaves;
}

bool contains(const Box3& outer, const Box3& inner) { return outer.contains(inner.lo) && outer.contains(inner.hi); }

}  // namespace

// Both lists are in Morton order, so that the pieces of a leaf follow each other. Corners only become smaller, so a
// leaf with the same size in its middle has the same corners.
std::optional<std::vector<Box3>> find_changes(const SizeField& before, const SizeField& after) {
  if (before.is_uniform() || after.is_uniform()) return std::nullopt;
  const std::vector<SizeLeaf> old_leaves = list_leaves(before), new_leaves = list_leaves(after);
  std::vector<Box3> changes;
  std::size_t next = 0;
  for (const SizeLeaf& leaf : old_leaves) {
    const std::size_t first = next;
    while (next < new_leaves.size() && contains(leaf.box, new_leaves[next].box)) ++next;
    if (next == first) return std::nullopt;
    const bool is_cut = next > first + 1;
    for (std::size_t i = first; i < next; ++i) {
      const double size = is_cut ? before.size_at(new_leaves[i].box.center()) : leaf.size;
      if (new_leaves[i].size != size) changes.push_back(new_leaves[i].box);
    }
  }
  if (next != new_leaves.size()) return std::nullopt;
  return changes;
}

}  // namespace tetloom
