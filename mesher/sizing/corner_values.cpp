#include "mesher/sizing/corner_values.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <span>
#include <utility>

#include "core/base/free_memory.hpp"
#include "core/base/lists.hpp"
#include "core/sizing/block_corners.hpp"
#include "core/spatial/morton.hpp"
#include "tetloom/tasks.hpp"
#include "threading/comm/own_share.hpp"

namespace tetloom {
namespace {

constexpr std::size_t kBlocksAtOnce = 64;  // blocks whose corners fit in a core's cache
constexpr std::uint32_t kDeepest = 1;      // the width of the leaves that are as deep as the tree goes

/// Of the stored corners of a block.
using CornerIds = std::array<std::uint32_t, StoredCorners::kInBlock>;
using Blocks = std::span<const OctreeBlock>;

const StoredCorners& corners_of(const SizeOctree& tree, const OctreeBlock& block) {
  return stored_corners(tree.cells.data() + block.first_cell);
}

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

/// The corners of some blocks.
class CornersOfSome {
 public:
  CornersOfSome(const SizeOctree& tree, Blocks blocks) : ids_(blocks.size()) {
    CodeNumbers numbers(StoredCorners::kInBlock * blocks.size());
    for (std::size_t i = 0; i < blocks.size(); ++i) {
      const StoredCorners& stored = corners_of(tree, blocks[i]);
      for (std::size_t k = 0; k < stored.count; ++k)
        ids_[i][k] = numbers.number(corner_code(blocks[i], stored.in_block[k]));
    }
    struct Numbered {
      std::uint64_t code;
      std::uint32_t number;
    };
    std::vector<Numbered> sorted;
    for (const std::uint64_t code : numbers.codes())
      sorted.push_back({code, static_cast<std::uint32_t>(sorted.size())});
    std::ranges::sort(sorted, {}, &Numbered::code);
    for (const Numbered& one : sorted) codes_.push_back(one.code), order_.push_back(one.number);
  }

  const std::vector<std::uint64_t>& codes() const { return codes_; }  ///< ascending
  /// Of each block, as places in what `places_in` returns.
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

  /// `corner`: of the 27.
  static std::uint64_t corner_code(const OctreeBlock& block, std::uint32_t corner) {
    return morton_encode({block.corner[0] + corner % 3 * block.width, block.corner[1] + corner / 3 % 3 * block.width,
                          block.corner[2] + corner / 9 * block.width});
  }

 private:
  std::vector<CornerIds> ids_;
  std::vector<std::uint64_t> codes_;
  std::vector<std::uint32_t> order_;  // of `codes_`, as `ids_` knows them
};

/// Every corner of the leaves of `blocks`, by its Morton code: the codes from bounds[r] on, below bounds[r + 1], ascend
/// in list r.
std::vector<std::vector<std::uint64_t>> codes_in_ranges(const SizeOctree& tree, Blocks blocks,
                                                        const std::vector<std::uint64_t>& bounds,
                                                        const TaskRunner& runner) {
  std::vector<std::vector<std::uint64_t>> lists((blocks.size() + kBlocksAtOnce - 1) / kBlocksAtOnce);
  runner.for_blocks(blocks.size(), kBlocksAtOnce, [&](std::size_t begin, std::size_t end) {
    lists[begin / kBlocksAtOnce] = CornersOfSome(tree, blocks.subspan(begin, end - begin)).codes();
  });
  // Lists ascend and nearly follow each other: range by range takes half the memory of sorting them all at once.
  std::vector<std::vector<std::uint64_t>> ranges(bounds.size() - 1);
  runner.for_each(ranges.size(), [&](std::size_t r) {
    std::vector<std::uint64_t>& range = ranges[r];
    for (const std::vector<std::uint64_t>& list : lists) {
      const auto first = std::ranges::lower_bound(list, bounds[r]);
      range.insert(range.end(), first, std::lower_bound(first, list.end(), bounds[r + 1]));
    }
    sort_unique(range);
    range.shrink_to_fit();
  });
  return ranges;
}

/// The lists of all ranks, one after the other; some of each at a time, so that messages are small beside them.
std::vector<std::uint64_t> gather_in_turns(std::span<const std::uint64_t> own, const SharedWork& work) {
  constexpr std::size_t kAtOnce = std::size_t{1} << 16;
  std::vector<std::size_t> firsts{0};
  std::size_t most = 0;
  for (const Bytes& bytes : work.all_gather([&](MessageWriter& writer) { writer.put(std::uint64_t{own.size()}); })) {
    const auto count = MessageReader(bytes).get<std::uint64_t>();
    firsts.push_back(firsts.back() + count), most = std::max<std::size_t>(most, count);
  }
  std::vector<std::uint64_t> all;
  work.each([&] { all.resize(firsts.back()); });
  const std::size_t turn = std::max<std::size_t>(1024, kAtOnce / static_cast<std::size_t>(work.rank_count()));
  for (std::size_t begin = 0; begin < most; begin += turn) {
    const std::vector<Bytes> given = work.all_gather([&](MessageWriter& writer) {
      const std::size_t from = std::min(begin, own.size());
      writer.put_array(own.subspan(from, std::min(turn, own.size() - from)));
    });
    for (std::size_t r = 0; r < given.size(); ++r)
      std::ranges::copy(MessageReader(given[r]).get_view<std::uint64_t>(),
                        all.begin() + static_cast<std::ptrdiff_t>(firsts[r] + begin));
  }
  return all;
}

/// Every corner of the blocks' leaves, once, by its Morton code. Each rank looks at some of the blocks, which lie along
/// the curve, and joins what all have found in some of the ranges.
std::vector<std::uint64_t> corner_codes(const SizeOctree& tree, Blocks blocks, const SharedWork& work) {
  constexpr std::size_t kRanges = 64;
  const auto rank = static_cast<std::size_t>(work.rank()), ranks = static_cast<std::size_t>(work.rank_count());
  std::vector<std::uint64_t> bounds{0, ~std::uint64_t{0}};
  const std::size_t wanted = std::max(kRanges, ranks);
  for (std::size_t r = 1; r < wanted && !blocks.empty(); ++r)
    bounds.push_back(CornersOfSome::corner_code(blocks[r * blocks.size() / wanted], 0));
  sort_unique(bounds);
  const ItemRange share = own_share(blocks.size(), work);
  if (ranks == 1) return joined(codes_in_ranges(tree, blocks, bounds, work.runner()));
  const auto owner_of = [&](std::size_t range) { return range * ranks / (bounds.size() - 1); };
  std::vector<Bytes> found = work.exchange([&](std::span<MessageWriter> to) {
    const auto own = codes_in_ranges(tree, blocks.subspan(share.first, share.size()), bounds, work.runner());
    for (std::size_t r = 0; r < own.size(); ++r) to[owner_of(r)].put_array<std::uint64_t>(own[r]);
  });
  std::vector<std::uint64_t> own;
  work.each([&] {
    std::vector<MessageReader> readers(found.begin(), found.end());
    std::vector<std::uint64_t> range;
    for (std::size_t r = 0; r + 1 < bounds.size(); ++r) {
      if (owner_of(r) != rank) continue;
      range.clear();
      for (MessageReader& reader : readers) {
        const auto some = reader.get_view<std::uint64_t>();
        range.insert(range.end(), some.begin(), some.end());
      }
      sort_unique(range);
      own.insert(own.end(), range.begin(), range.end());
    }
    found = {};
    give_back_free_memory();
  });
  return gather_in_turns(own, work);
}

/// Calls visit(i, ids) for the blocks, side by side: `ids` are the places of block i's corners in `codes`.
template <class Visit>
void for_each_block(const SizeOctree& tree, Blocks blocks, const std::vector<std::uint64_t>& codes,
                    const TaskRunner& runner, const Visit& visit) {
  runner.for_blocks(blocks.size(), kBlocksAtOnce, [&](std::size_t begin, std::size_t end) {
    const CornersOfSome corners(tree, blocks.subspan(begin, end - begin));
    const std::vector<std::uint32_t> places = corners.places_in(codes);
    for (std::size_t i = begin; i < end; ++i) {
      CornerIds ids = corners.ids()[i - begin];
      for (std::size_t k = 0; k < corners_of(tree, blocks[i]).count; ++k) ids[k] = places[ids[k]];
      visit(i, ids);
    }
  });
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

/// Lowers the corners of one leaf; returns whether any of them changed. `places`: of its corners among `ids`.
bool relax(const CornerIds& ids, const std::array<std::uint8_t, 8>& places, double growth, std::vector<double>& sizes) {
  static const std::array<double, 4> kDistance{0, 1, std::sqrt(2.0), std::sqrt(3.0)};
  bool changed = false;
  for (std::uint32_t a = 0; a < 8; ++a)
    for (std::uint32_t b = a + 1; b < 8; ++b) {
      const std::uint32_t differ = a ^ b;
      const double step = growth * kDistance[(differ & 1) + (differ >> 1 & 1) + (differ >> 2)];
      double &at_a = sizes[ids[places[a]]], &at_b = sizes[ids[places[b]]];
      if (at_a > at_b + step) at_a = at_b + step, changed = true;
      if (at_b > at_a + step) at_b = at_a + step, changed = true;
    }
  return changed;
}

/// Of a block with leaves that need sizes.
std::size_t first_ratio(const SizeOctree& tree, const OctreeBlock& block) {
  const std::uint32_t* const cells = tree.cells.data() + block.first_cell;
  return *std::find_if(cells, cells + 8, is_sized_leaf) - SizeOctree::kLeafBit;
}

/// Calls visit(octant) for the leaves of a block that need sizes.
template <class Visit>
void for_each_sized_leaf(const SizeOctree& tree, const OctreeBlock& block, const Visit& visit) {
  for (std::size_t octant = 0; octant < 8; ++octant)
    if (is_sized_leaf(tree.cells[block.first_cell + octant])) visit(octant);
}

/// Sweeps to and fro along the Morton curve until nothing changes. What comes out does not depend on their order.
void enforce_gradation(const SizeOctree& tree, Blocks blocks, const std::vector<std::uint64_t>& codes,
                       std::vector<double>& sizes, const TaskRunner& runner) {
  std::vector<CornerIds> block_to_ids(blocks.size());
  for_each_block(tree, blocks, codes, runner, [&](std::size_t i, const CornerIds& ids) { block_to_ids[i] = ids; });
  const double growth_per_unit = tree.gradation * std::ldexp(tree.width, -SizeOctree::kMaxDepth);
  const auto relax_block = [&](std::size_t i) {
    bool changed = false;
    const StoredCorners& stored = corners_of(tree, blocks[i]);
    for_each_sized_leaf(tree, blocks[i], [&](std::size_t octant) {
      changed |= relax(block_to_ids[i], stored.places[octant], growth_per_unit * blocks[i].width, sizes);
    });
    return changed;
  };
  bool changed = true;
  while (changed) {
    runner.check_cancelled();
    changed = false;
    for (std::size_t i = 0; i < blocks.size(); ++i) changed |= relax_block(i);
    for (std::size_t i = blocks.size(); i-- > 0 && changed;) relax_block(i);
  }
}

/// Leaves as deep as the tree goes may be wider than a size asked for inside them; their corners take the smallest.
void lower_deepest_leaves(const SizeOctree& tree, Blocks blocks, const std::vector<std::uint64_t>& codes,
                          const TargetField& field, std::vector<double>& sizes) {
  const double unit = std::ldexp(tree.width, -SizeOctree::kMaxDepth);
  for (const OctreeBlock& block : blocks) {
    if (block.width != kDeepest) continue;
    for_each_sized_leaf(tree, block, [&](std::size_t octant) {
      const Vec3 corner{double(block.corner[0] + (octant & 1)), double(block.corner[1] + (octant >> 1 & 1)),
                        double(block.corner[2] + (octant >> 2))};
      std::uint32_t winner = SourceTree::kNoSource;
      const double least = field.lower_bound(tree.origin + unit * (corner + Vec3{0.5, 0.5, 0.5}), 0.87 * unit, winner);
      for (std::size_t k = 0; k < 8; ++k) {
        const auto in_block = static_cast<std::uint32_t>(corner_in_block(octant, k));
        const auto at = std::ranges::lower_bound(codes, CornersOfSome::corner_code(block, in_block));
        double& size = sizes[static_cast<std::size_t>(at - codes.begin())];
        size = std::min(size, least);
      }
    });
  }
}

/// Leaves that hold the global size at all corners need no ratios; the others keep their order.
void drop_global_leaves(SizeOctree& tree, Blocks blocks) {
  std::vector<float>& ratios = tree.corner_ratios;
  std::size_t from = 0, kept = 0;
  for (const OctreeBlock& block : blocks) {
    const StoredCorners& before = corners_of(tree, block);
    std::array<float, StoredCorners::kInBlock> in_block;
    for (std::size_t k = 0; k < before.count; ++k) in_block[before.in_block[k]] = ratios[from + k];
    from += before.count;
    for_each_sized_leaf(tree, block, [&](std::size_t octant) {
      bool is_global = true;
      for (std::size_t k = 0; k < 8; ++k) is_global = is_global && in_block[corner_in_block(octant, k)] == 1;
      tree.cells[block.first_cell + octant] =
          is_global ? SizeOctree::kGlobalLeaf : SizeOctree::kLeafBit + static_cast<std::uint32_t>(kept);
    });
    const StoredCorners& stored = corners_of(tree, block);
    for (std::size_t k = 0; k < stored.count; ++k) ratios[kept++] = in_block[stored.in_block[k]];
  }
  const bool is_worth_a_copy = kept < ratios.size() / 4 * 3;
  ratios.resize(kept);
  if (is_worth_a_copy) ratios.shrink_to_fit();
}

/// Blocks have their ratios in their own order, one after the other.
void put_ratios(SizeOctree& tree, Blocks blocks, const std::vector<std::uint64_t>& codes,
                const std::vector<double>& sizes, const SharedWork& work) {
  constexpr std::size_t kRatiosAtOnce = std::size_t{1} << 12;
  if (blocks.empty()) return;
  tree.corner_ratios.resize(first_ratio(tree, blocks.back()) + corners_of(tree, blocks.back()).count);
  const auto first_of = [&](const OctreeBlock& block) { return first_ratio(tree, block); };
  work.fill<float>(tree.corner_ratios, kRatiosAtOnce, [&](std::size_t begin, std::size_t end) {
    // From the block that has the first of them.
    const auto after = std::ranges::upper_bound(blocks, begin, {}, first_of);
    const auto stop = std::lower_bound(
        after, blocks.end(), end, [&](const OctreeBlock& block, std::size_t ratio) { return first_of(block) < ratio; });
    const Blocks some(after - 1, stop);
    const CornersOfSome corners(tree, some);
    const std::vector<std::uint32_t> places = corners.places_in(codes);
    for (std::size_t i = 0; i < some.size(); ++i) {
      const std::size_t first = first_of(some[i]), count = corners_of(tree, some[i]).count;
      for (std::size_t k = 0; k < count; ++k) {
        if (first + k < begin || first + k >= end) continue;
        const double size = sizes[places[corners.ids()[i][k]]];
        tree.corner_ratios[first + k] = static_cast<float>(std::min(1.0, size / tree.size));
      }
    }
  });
}

/// What is asked for at corners as the tree may have it; nothing where that is the same.
std::vector<double> lower_corners(const SizeOctree& tree, Blocks blocks, const TargetField& field,
                                  const CornerSizes& asked, const TaskRunner& runner) {
  const bool is_deep = std::ranges::any_of(blocks, [](const OctreeBlock& block) { return block.width == kDeepest; });
  if (!is_deep && !field.may_be_steep()) return {};
  std::vector<double> sizes = asked.sizes;
  lower_deepest_leaves(tree, blocks, asked.codes, field, sizes);
  if (field.may_be_steep()) enforce_gradation(tree, blocks, asked.codes, sizes, runner);
  return sizes;
}

}  // namespace

CornerSizes fill_corner_ratios(SizeOctree& tree, const std::vector<OctreeBlock>& blocks, const TargetField& field,
                               const CornerSizes& known, const SharedWork& work) {
  const TaskRunner& runner = work.runner();
  CornerSizes asked{corner_codes(tree, blocks, work), {}};
  asked.sizes = evaluate_corners(tree, asked.codes, field, known, work);
  const std::vector<double> lowered = lower_corners(tree, blocks, field, asked, runner);
  put_ratios(tree, blocks, asked.codes, lowered.empty() ? asked.sizes : lowered, work);
  drop_global_leaves(tree, blocks);
  return own_corners(std::move(asked), work);
}

}  // namespace tetloom
