#include "mesher/sizing/corner_values.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

#include "core/sizing/morton.hpp"
#include "threading/parallel_sort.hpp"

namespace tetloom {
namespace {

constexpr std::size_t kBlock = 2048;  // leaves whose corners fit in a core's cache

using CornerIds = std::array<std::uint32_t, 8>;

/// Every corner of the leaves, once, by its Morton code.
class CornerTable {
 public:
  CornerTable(const std::vector<OctreeLeaf>& leaves, const TaskRunner& runner) : leaves_(leaves), runner_(runner) {
    const std::size_t block_count = (leaves.size() + kBlock - 1) / kBlock;
    std::vector<std::vector<std::uint64_t>> blocks(block_count);
    runner.for_blocks(leaves.size(), kBlock,
                      [&](std::size_t begin, std::size_t end) { blocks[begin / kBlock] = corners_of(begin, end); });
    std::vector<std::size_t> first{0};
    for (const auto& block : blocks) first.push_back(first.back() + block.size());
    codes_.resize(first.back());
    runner.for_each(blocks.size(), [&](std::size_t b) {
      std::ranges::copy(blocks[b], codes_.begin() + static_cast<std::ptrdiff_t>(first[b]));
    });
    parallel_sort_unique(codes_, runner);
    find_ids(blocks);
  }

  const std::vector<std::uint64_t>& codes() const { return codes_; }
  const std::vector<CornerIds>& ids() const { return ids_; }

 private:
  static std::uint64_t corner_code(const OctreeLeaf& leaf, std::uint32_t octant) {
    return morton_encode({leaf.corner[0] + (octant & 1) * leaf.width, leaf.corner[1] + (octant >> 1 & 1) * leaf.width,
                          leaf.corner[2] + (octant >> 2) * leaf.width});
  }

  std::vector<std::uint64_t> corners_of(std::size_t begin, std::size_t end) const {
    std::vector<std::uint64_t> codes;
    codes.reserve(8 * (end - begin));
    for (std::size_t i = begin; i < end; ++i)
      for (std::uint32_t octant = 0; octant < 8; ++octant) codes.push_back(corner_code(leaves_[i], octant));
    std::ranges::sort(codes);
    codes.erase(std::unique(codes.begin(), codes.end()), codes.end());
    return codes;
  }

  /// Looks each leaf's corners up among those of its block, which are few, and these once in the whole table.
  void find_ids(const std::vector<std::vector<std::uint64_t>>& blocks) {
    ids_.resize(leaves_.size());
    runner_.for_blocks(leaves_.size(), kBlock, [&](std::size_t begin, std::size_t end) {
      const std::vector<std::uint64_t>& block = blocks[begin / kBlock];
      std::vector<std::uint32_t> block_to_table;
      auto from = codes_.begin();
      for (const std::uint64_t code : block) {
        from = std::lower_bound(from, codes_.end(), code);
        block_to_table.push_back(static_cast<std::uint32_t>(from - codes_.begin()));
      }
      for (std::size_t i = begin; i < end; ++i)
        for (std::uint32_t octant = 0; octant < 8; ++octant) {
          const auto at = std::ranges::lower_bound(block, corner_code(leaves_[i], octant));
          ids_[i][octant] = block_to_table[static_cast<std::size_t>(at - block.begin())];
        }
    });
  }

  const std::vector<OctreeLeaf>& leaves_;
  const TaskRunner& runner_;
  std::vector<std::uint64_t> codes_;
  std::vector<CornerIds> ids_;
};

std::vector<double> evaluate_corners(const SizeOctree& tree, const std::vector<std::uint64_t>& codes,
                                     const TargetField& field, const SharedWork& work) {
  std::vector<double> sizes(codes.size());
  const double unit = std::ldexp(tree.width, -SizeOctree::kMaxDepth);
  work.fill<double>(sizes, 1024, [&](std::size_t begin, std::size_t end) {
    std::uint32_t winner = SourceTree::kNoSource;
    for (std::size_t i = begin; i < end; ++i) {
      const std::array<std::uint32_t, 3> at = morton_decode(codes[i]);
      sizes[i] = field.size_at(tree.origin + unit * Vec3{double(at[0]), double(at[1]), double(at[2])}, winner);
    }
  });
  return sizes;
}

/// Lowers the corners of one leaf; returns whether any of them changed.
bool relax(const CornerIds& ids, double growth, std::vector<double>& sizes) {
  static const std::array<double, 4> kDistance{0, 1, std::sqrt(2.0), std::sqrt(3.0)};
  bool changed = false;
  for (std::uint32_t a = 0; a < 8; ++a)
    for (std::uint32_t b = a + 1; b < 8; ++b) {
      const std::uint32_t differ = a ^ b;
      const double step = growth * kDistance[(differ & 1) + (differ >> 1 & 1) + (differ >> 2)];
      double &at_a = sizes[ids[a]], &at_b = sizes[ids[b]];
      if (at_a > at_b + step) at_a = at_b + step, changed = true;
      if (at_b > at_a + step) at_b = at_a + step, changed = true;
    }
  return changed;
}

/// Sweeps to and fro along the Morton curve until nothing changes.
void enforce_gradation(const SizeOctree& tree, const std::vector<OctreeLeaf>& leaves, const std::vector<CornerIds>& ids,
                       std::vector<double>& sizes, const TaskRunner& runner) {
  const double growth_per_unit = tree.gradation * std::ldexp(tree.width, -SizeOctree::kMaxDepth);
  bool changed = true;
  while (changed) {
    runner.check_cancelled();
    changed = false;
    for (std::size_t i = 0; i < leaves.size(); ++i) changed |= relax(ids[i], growth_per_unit * leaves[i].width, sizes);
    for (std::size_t i = leaves.size(); i-- > 0 && changed;) relax(ids[i], growth_per_unit * leaves[i].width, sizes);
  }
}

/// Leaves as deep as the tree goes may be wider than a size asked for inside them; their corners take the smallest.
void lower_deepest_leaves(const SizeOctree& tree, const std::vector<OctreeLeaf>& leaves,
                          const std::vector<CornerIds>& ids, const TargetField& field, std::vector<double>& sizes) {
  const double unit = std::ldexp(tree.width, -SizeOctree::kMaxDepth);
  for (std::size_t i = 0; i < leaves.size(); ++i) {
    if (leaves[i].width != 1) continue;
    const Vec3 corner{double(leaves[i].corner[0]), double(leaves[i].corner[1]), double(leaves[i].corner[2])};
    std::uint32_t winner = SourceTree::kNoSource;
    const double least = field.lower_bound(tree.origin + unit * (corner + Vec3{0.5, 0.5, 0.5}), 0.87 * unit, winner);
    for (const std::uint32_t id : ids[i]) sizes[id] = std::min(sizes[id], least);
  }
}

/// Drops the entries of leaves that hold the global size at all corners; the others keep their order.
void drop_global_leaves(SizeOctree& tree) {
  std::vector<std::uint32_t> new_codes(tree.corner_ratios.size(), SizeOctree::kGlobalLeaf);
  std::uint32_t kept = 0;
  for (std::size_t i = 0; i < tree.corner_ratios.size(); ++i) {
    if (std::ranges::all_of(tree.corner_ratios[i], [](float ratio) { return ratio == 1; })) continue;
    tree.corner_ratios[kept] = tree.corner_ratios[i];
    new_codes[i] = SizeOctree::kLeafBit + kept++;
  }
  tree.corner_ratios.resize(kept);
  tree.corner_ratios.shrink_to_fit();
  for (std::uint32_t& code : tree.cells)
    if (code >= SizeOctree::kLeafBit && code != SizeOctree::kGlobalLeaf) code = new_codes[code - SizeOctree::kLeafBit];
}

}  // namespace

void fill_corner_ratios(SizeOctree& tree, const std::vector<OctreeLeaf>& leaves, const TargetField& field,
                        const SharedWork& work) {
  const TaskRunner& runner = work.runner();
  const CornerTable table(leaves, runner);
  std::vector<double> sizes = evaluate_corners(tree, table.codes(), field, work);
  lower_deepest_leaves(tree, leaves, table.ids(), field, sizes);
  if (field.may_be_steep()) enforce_gradation(tree, leaves, table.ids(), sizes, runner);
  tree.corner_ratios.resize(leaves.size());
  runner.for_blocks(leaves.size(), kBlock, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i)
      for (std::size_t octant = 0; octant < 8; ++octant)
        tree.corner_ratios[i][octant] = static_cast<float>(std::min(1.0, sizes[table.ids()[i][octant]] / tree.size));
  });
  drop_global_leaves(tree);
}

}  // namespace tetloom
