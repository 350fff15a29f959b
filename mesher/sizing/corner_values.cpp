#include "mesher/sizing/corner_values.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <numeric>

#include "core/spatial/morton.hpp"
#include "tetloom/tasks.hpp"
#include "threading/runtime/parallel_sort.hpp"

namespace tetloom {
namespace {

constexpr std::size_t kBlock = 512;  // leaves whose corners fit in a core's cache

using CornerIds = std::array<std::uint32_t, 8>;

/// Codes numbered in the order in which they come: open addressing with linear probing.
class CodeNumbers {
 public:
  explicit CodeNumbers(std::size_t most) : slots_(std::bit_ceil(2 * most), kFree), keys_(slots_.size()) {}

  std::uint32_t number(std::uint64_t code) {
    constexpr std::uint64_t kSpread = 0x9e3779b97f4a7c15ull;
    const std::size_t mask = slots_.size() - 1;
    std::size_t slot = (code * kSpread) >> 32 & mask;
    while (slots_[slot] != kFree && keys_[slot] != code) slot = (slot + 1) & mask;
    if (slots_[slot] == kFree) {
      slots_[slot] = static_cast<std::uint32_t>(codes_.size());
      keys_[slot] = code;
      codes_.push_back(code);
    }
    return slots_[slot];
  }

  const std::vector<std::uint64_t>& codes() const { return codes_; }

 private:
  static constexpr std::uint32_t kFree = 0xffffffffu;
  std::vector<std::uint32_t> slots_;
  std::vector<std::uint64_t> keys_;
  std::vector<std::uint64_t> codes_;
};

/// Every corner of the leaves, once, by its Morton code.
class CornerTable {
 public:
  CornerTable(const std::vector<OctreeLeaf>& leaves, const TaskRunner& runner) : leaves_(leaves), runner_(runner) {
    std::vector<Block> blocks((leaves.size() + kBlock - 1) / kBlock);
    ids_.resize(leaves.size());
    runner.for_blocks(leaves.size(), kBlock,
                      [&](std::size_t begin, std::size_t end) { blocks[begin / kBlock] = number(begin, end); });
    std::vector<std::size_t> first{0};
    for (const Block& block : blocks) first.push_back(first.back() + block.codes.size());
    codes_.resize(first.back());
    runner.for_each(blocks.size(), [&](std::size_t b) {
      std::ranges::copy(blocks[b].codes, codes_.begin() + static_cast<std::ptrdiff_t>(first[b]));
    });
    parallel_sort_unique(codes_, runner);
    runner.for_blocks(leaves.size(), kBlock,
                      [&](std::size_t begin, std::size_t end) { renumber(begin, end, blocks[begin / kBlock]); });
  }

  const std::vector<std::uint64_t>& codes() const { return codes_; }
  const std::vector<CornerIds>& ids() const { return ids_; }

 private:
  /// The corners of a block of leaves.
  struct Block {
    std::vector<std::uint64_t> codes;  ///< ascending
    std::vector<std::uint32_t> order;  ///< of `codes`, as `ids_` knows them
  };

  static std::uint64_t corner_code(const OctreeLeaf& leaf, std::uint32_t octant) {
    return morton_encode({leaf.corner[0] + (octant & 1) * leaf.width, leaf.corner[1] + (octant >> 1 & 1) * leaf.width,
                          leaf.corner[2] + (octant >> 2) * leaf.width});
  }

  Block number(std::size_t begin, std::size_t end) {
    CodeNumbers numbers(8 * (end - begin));
    for (std::size_t i = begin; i < end; ++i)
      for (std::uint32_t octant = 0; octant < 8; ++octant)
        ids_[i][octant] = numbers.number(corner_code(leaves_[i], octant));
    Block block;
    block.order.resize(numbers.codes().size());
    std::iota(block.order.begin(), block.order.end(), 0u);
    std::ranges::sort(block.order, {}, [&](std::uint32_t n) { return numbers.codes()[n]; });
    for (const std::uint32_t n : block.order) block.codes.push_back(numbers.codes()[n]);
    return block;
  }

  /// From the numbers in a block to those in the whole table.
  void renumber(std::size_t begin, std::size_t end, const Block& block) {
    std::vector<std::uint32_t> to_table(block.codes.size());
    auto from = codes_.begin();
    for (std::size_t i = 0; i < block.codes.size(); ++i) {
      from = std::lower_bound(from, codes_.end(), block.codes[i]);
      to_table[block.order[i]] = static_cast<std::uint32_t>(from - codes_.begin());
    }
    for (std::size_t i = begin; i < end; ++i)
      for (std::uint32_t& id : ids_[i]) id = to_table[id];
  }

  const std::vector<OctreeLeaf>& leaves_;
  const TaskRunner& runner_;
  std::vector<std::uint64_t> codes_;
  std::vector<CornerIds> ids_;
};

std::vector<double> evaluate_corners(const SizeOctree& tree, const std::vector<std::uint64_t>& codes,
                                     const TargetField& field, const CornerSizes& known, const SharedWork& work) {
  std::vector<double> sizes(codes.size());
  const double unit = std::ldexp(tree.width, -SizeOctree::kMaxDepth);
  work.fill<double>(sizes, 1024, [&](std::size_t begin, std::size_t end) {
    std::uint32_t winner = SourceTree::kNoSource;
    auto met = std::ranges::lower_bound(known.codes, codes[begin]);
    for (std::size_t i = begin; i < end; ++i) {
      const std::array<std::uint32_t, 3> at = morton_decode(codes[i]);
      const Vec3 x = tree.origin + unit * Vec3{double(at[0]), double(at[1]), double(at[2])};
      while (met != known.codes.end() && *met < codes[i]) ++met;
      if (met != known.codes.end() && *met == codes[i])
        sizes[i] = field.lowered_at(x, known.sizes[static_cast<std::size_t>(met - known.codes.begin())]);
      else
        sizes[i] = field.size_at(x, winner);
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

CornerSizes fill_corner_ratios(SizeOctree& tree, const std::vector<OctreeLeaf>& leaves, const TargetField& field,
                               const CornerSizes& known, const SharedWork& work) {
  const TaskRunner& runner = work.runner();
  const CornerTable table(leaves, runner);
  std::vector<double> sizes = evaluate_corners(tree, table.codes(), field, known, work);
  CornerSizes found{table.codes(), sizes};
  lower_deepest_leaves(tree, leaves, table.ids(), field, sizes);
  if (field.may_be_steep()) enforce_gradation(tree, leaves, table.ids(), sizes, runner);
  tree.corner_ratios.resize(leaves.size());
  runner.for_blocks(leaves.size(), kBlock, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i)
      for (std::size_t octant = 0; octant < 8; ++octant)
        tree.corner_ratios[i][octant] = static_cast<float>(std::min(1.0, sizes[table.ids()[i][octant]] / tree.size));
  });
  drop_global_leaves(tree);
  return found;
}

}  // namespace tetloom
