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

constexpr std::size_t kLeavesAtOnce = 512;  // leaves whose corners fit in a core's cache
constexpr std::uint32_t kDeepest = 1;       // the width of the leaves that are as deep as the tree goes

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

/// The corners of a block of leaves.
class BlockCorners {
 public:
  explicit BlockCorners(std::span<const OctreeLeaf> leaves) : ids_(leaves.size()) {
    CodeNumbers numbers(8 * leaves.size());
    for (std::size_t i = 0; i < leaves.size(); ++i)
      for (std::uint32_t octant = 0; octant < 8; ++octant)
        ids_[i][octant] = numbers.number(corner_code(leaves[i], octant));
    order_.resize(numbers.codes().size());
    std::iota(order_.begin(), order_.end(), 0u);
    std::ranges::sort(order_, {}, [&](std::uint32_t n) { return numbers.codes()[n]; });
    for (const std::uint32_t n : order_) codes_.push_back(numbers.codes()[n]);
  }

  const std::vector<std::uint64_t>& codes() const { return codes_; }  ///< ascending
  /// Of each leaf, as places in what `places_in` returns.
  const std::vector<CornerIds>& ids() const { return ids_; }
  /// The place of each corner in `all`, which ascends and has them all.
  std::vector<std::uint32_t> places_in(const std::vector<std::uint64_t>& all) const {
    std::vector<std::uint32_t> places(codes_.size());
    auto from = all.begin();
    for (std::size_t i = 0; i < codes_.size(); ++i) {
      from = std::lower_bound(from, all.end(), codes_[i]);
      places[order_[i]] = static_cast<std::uint32_t>(from - all.begin());
    }
    return places;
  }

  static std::uint64_t corner_code(const OctreeLeaf& leaf, std::uint32_t octant) {
    return morton_encode({leaf.corner[0] + (octant & 1) * leaf.width, leaf.corner[1] + (octant >> 1 & 1) * leaf.width,
                          leaf.corner[2] + (octant >> 2) * leaf.width});
  }

 private:
  std::vector<CornerIds> ids_;
  std::vector<std::uint64_t> codes_;
  std::vector<std::uint32_t> order_;  // of `codes_`, as `ids_` knows them
};

/// Every corner of the leaves, once, by its Morton code.
std::vector<std::uint64_t> corner_codes(std::span<const OctreeLeaf> leaves, const TaskRunner& runner) {
  std::vector<std::vector<std::uint64_t>> blocks((leaves.size() + kLeavesAtOnce - 1) / kLeavesAtOnce);
  runner.for_blocks(leaves.size(), kLeavesAtOnce, [&](std::size_t begin, std::size_t end) {
    blocks[begin / kLeavesAtOnce] = BlockCorners(leaves.subspan(begin, end - begin)).codes();
  });
  std::vector<std::size_t> first{0};
  for (const auto& block : blocks) first.push_back(first.back() + block.size());
  std::vector<std::uint64_t> codes(first.back());
  runner.for_each(blocks.size(), [&](std::size_t b) {
    std::ranges::copy(blocks[b], codes.begin() + static_cast<std::ptrdiff_t>(first[b]));
    blocks[b] = {};
  });
  parallel_sort_unique(codes, runner);
  codes.shrink_to_fit();
  return codes;
}

/// The corners of every leaf, as places in `codes`.
std::vector<CornerIds> corner_ids(std::span<const OctreeLeaf> leaves, const std::vector<std::uint64_t>& codes,
                                  const TaskRunner& runner) {
  std::vector<CornerIds> ids(leaves.size());
  runner.for_blocks(leaves.size(), kLeavesAtOnce, [&](std::size_t begin, std::size_t end) {
    const BlockCorners corners(leaves.subspan(begin, end - begin));
    const std::vector<std::uint32_t> places = corners.places_in(codes);
    for (std::size_t i = begin; i < end; ++i)
      for (std::size_t octant = 0; octant < 8; ++octant) ids[i][octant] = places[corners.ids()[i - begin][octant]];
  });
  return ids;
}

int rank_of_corner(std::uint64_t code, const SharedWork& work) {
  return rank_at(code, SizeOctree::kMaxDepth, work.rank_count());
}

/// Those that this rank looked at.
CornerSizes own_corners(CornerSizes&& all, const SharedWork& work) {
  if (work.rank_count() == 1) return std::move(all);
  CornerSizes own;
  for (std::size_t i = 0; i < all.codes.size(); ++i) {
    if (rank_of_corner(all.codes[i], work) != work.rank()) continue;
    own.codes.push_back(all.codes[i]);
    own.sizes.push_back(all.sizes[i]);
  }
  return own;
}

std::vector<double> evaluate_corners(const SizeOctree& tree, const std::vector<std::uint64_t>& codes,
                                     const TargetField& field, const CornerSizes& known, const SharedWork& work) {
  std::vector<double> sizes(codes.size());
  const double unit = std::ldexp(tree.width, -SizeOctree::kMaxDepth);
  const auto owner_of = [&](std::size_t i) { return rank_of_corner(codes[i], work); };
  work.fill<double>(sizes, 1024, owner_of, [&](std::size_t begin, std::size_t end) {
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
                          const std::vector<std::uint64_t>& codes, const TargetField& field,
                          std::vector<double>& sizes) {
  const double unit = std::ldexp(tree.width, -SizeOctree::kMaxDepth);
  for (const OctreeLeaf& leaf : leaves) {
    if (leaf.width != kDeepest) continue;
    const Vec3 corner{double(leaf.corner[0]), double(leaf.corner[1]), double(leaf.corner[2])};
    std::uint32_t winner = SourceTree::kNoSource;
    const double least = field.lower_bound(tree.origin + unit * (corner + Vec3{0.5, 0.5, 0.5}), 0.87 * unit, winner);
    for (std::uint32_t octant = 0; octant < 8; ++octant) {
      const auto at = std::ranges::lower_bound(codes, BlockCorners::corner_code(leaf, octant));
      double& size = sizes[static_cast<std::size_t>(at - codes.begin())];
      size = std::min(size, least);
    }
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
  const bool is_worth_a_copy = kept < new_codes.size() / 4 * 3;
  tree.corner_ratios.resize(kept);
  if (is_worth_a_copy) tree.corner_ratios.shrink_to_fit();
  for (std::uint32_t& code : tree.cells)
    if (code >= SizeOctree::kLeafBit && code != SizeOctree::kGlobalLeaf) code = new_codes[code - SizeOctree::kLeafBit];
}

/// What is asked for at corners as the tree may have it; nothing where that is the same.
std::vector<double> lower_corners(const SizeOctree& tree, const std::vector<OctreeLeaf>& leaves,
                                  const TargetField& field, const CornerSizes& asked, const TaskRunner& runner) {
  const bool is_deep = std::ranges::any_of(leaves, [](const OctreeLeaf& leaf) { return leaf.width == kDeepest; });
  if (!is_deep && !field.may_be_steep()) return {};
  std::vector<double> sizes = asked.sizes;
  lower_deepest_leaves(tree, leaves, asked.codes, field, sizes);
  if (field.may_be_steep()) enforce_gradation(tree, leaves, corner_ids(leaves, asked.codes, runner), sizes, runner);
  return sizes;
}

}  // namespace

CornerSizes fill_corner_ratios(SizeOctree& tree, const std::vector<OctreeLeaf>& leaves, const TargetField& field,
                               const CornerSizes& known, const SharedWork& work) {
  const TaskRunner& runner = work.runner();
  CornerSizes asked{corner_codes(leaves, runner), {}};
  asked.sizes = evaluate_corners(tree, asked.codes, field, known, work);
  const std::vector<double> lowered = lower_corners(tree, leaves, field, asked, runner);
  const std::vector<double>& sizes = lowered.empty() ? asked.sizes : lowered;
  tree.corner_ratios.resize(leaves.size());
  runner.for_blocks(leaves.size(), kLeavesAtOnce, [&](std::size_t begin, std::size_t end) {
    const BlockCorners corners(std::span<const OctreeLeaf>(leaves).subspan(begin, end - begin));
    const std::vector<std::uint32_t> places = corners.places_in(asked.codes);
    for (std::size_t i = begin; i < end; ++i)
      for (std::size_t octant = 0; octant < 8; ++octant) {
        const double size = sizes[places[corners.ids()[i - begin][octant]]];
        tree.corner_ratios[i][octant] = static_cast<float>(std::min(1.0, size / tree.size));
      }
  });
  drop_global_leaves(tree);
  return own_corners(std::move(asked), work);
}

}  // namespace tetloom
