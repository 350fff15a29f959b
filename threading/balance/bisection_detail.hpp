#pragma once
// Recursive bisection of all items by any key: the search for cuts by refined histograms, level by level.
#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <span>
#include <vector>

#include "threading/balance/items_detail.hpp"

namespace tetloom::balance_detail {

constexpr std::size_t kMaxComponents = 4;
constexpr std::uint32_t kNoSet = 0xffffffff;

/// Keys are tuples of up to four numbers, ordered lexicographically; each is below 2^63. Further components only break
/// ties, so nearly all work is on the first.
using CutKey = std::array<std::uint64_t, kMaxComponents>;

/// The search for the place where a set is cut. Items with keys below `low` at the current component weigh `below`.
struct Search {
  std::uint32_t component = 0;
  std::uint64_t low = 0, high = 0;  ///< the key of the cut is in [low, high]
  int shift = 0;                    ///< a bin is 2^shift keys wide
  std::int64_t below = 0;
  CutKey at{};  ///< components before the current one are settled; once done: items with smaller keys go left
  bool done = false;
};

/// Items that are bound for the targets first … first + count - 1 and carry the label `first`.
struct ItemSet {
  std::uint32_t first = 0;
  std::uint32_t count = 1;
  std::int64_t weight = 0;
  Search search;

  std::uint32_t left_count() const { return count / 2; }
  /// What of `total` belongs on the left: floor(total · left_count / count), without overflow.
  std::int64_t left_share(std::int64_t total) const {
    const std::int64_t all = count, left = left_count();
    return total / all * left + total % all * left / all;
  }
};

int bin_shift(std::uint64_t low, std::uint64_t high, std::uint64_t bins);
/// How many bins each of `sets` histograms may have so that all of them stay within the memory of a lane.
std::uint64_t bins_for(std::size_t sets);
/// Settles the cut or narrows the search. `histogram`: what lies below `low`, the bins, what lies above them; of items
/// that agree with the settled components. `highest`: the greatest value of each component.
void narrow(ItemSet& set, std::span<const std::int64_t> histogram, std::span<const std::uint64_t> highest);
/// Both halves of a set whose search is done.
std::array<ItemSet, 2> halves(const ItemSet& set);

/// `Keys` gives keys and plans cuts:
///   std::span<const std::uint64_t> highest() const;
///   void plan(std::span<ItemSet> sets);         // may set low and high to where it expects the cut
///   void split(std::span<const ItemSet> sets);  // after a level, with the cuts that were found
///   Reader reader(std::uint32_t block) const;   // a copy of all that a loop over a block needs:
///     std::uint64_t first(std::size_t set, std::size_t item) const;
///     std::uint64_t component(std::size_t set, std::size_t item, std::uint32_t component) const;
template <class Keys>
class Bisection {
 public:
  Bisection(const Items& items, Keys& keys, TargetRange range)
      : items_(items), keys_(keys), range_(range), set_of_(range.count, kNoSet) {
    items_.for_chunks(items_.lanes(0), [&](std::size_t, const Chunk& chunk) {
      auto targets = items_.blocks()[chunk.block].targets.subspan(chunk.begin, chunk.end - chunk.begin);
      std::fill(targets.begin(), targets.end(), range.first);
    });
  }

  void run() {
    std::vector<ItemSet> sets;
    if (range_.count > 1) sets.push_back({range_.first, range_.count, items_.weight(), {}});
    while (!sets.empty()) {
      for (ItemSet& set : sets) set.search.high = keys_.highest()[0];
      number(sets);
      keys_.plan(sets);
      find_cuts(sets);
      apply_cuts(sets);
      keys_.split(sets);
      sets = next_level(sets);
    }
  }

 private:
  void number(std::span<const ItemSet> sets) {
    std::fill(set_of_.begin(), set_of_.end(), kNoSet);
    for (std::uint32_t s = 0; s < sets.size(); ++s) set_of_[sets[s].first - range_.first] = s;
  }

  void find_cuts(std::span<ItemSet> sets) {
    for (;;) {
      std::vector<std::uint32_t> slot(sets.size(), kNoSet);
      std::uint32_t searching = 0;
      for (std::size_t s = 0; s < sets.size(); ++s)
        if (!sets[s].search.done) slot[s] = searching++;
      if (searching == 0) return;
      const std::uint64_t bins = bins_for(searching);
      for (ItemSet& set : sets) set.search.shift = bin_shift(set.search.low, set.search.high, bins);
      const auto sums = items_.sum_over_items(searching * (bins + 2), [&](auto histogram, const Chunk& chunk) {
        add_chunk(sets, slot, bins, histogram, chunk);
      });
      for (std::size_t s = 0; s < sets.size(); ++s)
        if (slot[s] != kNoSet)
          narrow(sets[s], std::span(sums).subspan(slot[s] * (bins + 2), bins + 2), keys_.highest());
    }
  }

  void add_chunk(std::span<const ItemSet> sets, std::span<const std::uint32_t> slot, std::uint64_t bins,
                 std::span<std::int64_t> histogram, const Chunk& chunk) const {
    const ItemBlock block = items_.blocks()[chunk.block];
    const auto keys = keys_.reader(chunk.block);
    const Frame frame = items_.frame();
    const std::uint32_t* set_of = set_of_.data();
    for (std::size_t i = chunk.begin; i < chunk.end; ++i) {
      const std::uint32_t s = set_of[block.targets[i] - range_.first];
      if (s == kNoSet || slot[s] == kNoSet) continue;
      const Search& search = sets[s].search;
      std::uint64_t key = keys.first(s, i);
      if (search.component > 0) {
        if (compare(keys, search, search.component, s, i) != 0) continue;
        key = keys.component(s, i, search.component);
      }
      const std::uint64_t bin = key < search.low ? 0 : std::min((key - search.low) >> search.shift, bins) + 1;
      histogram[slot[s] * (bins + 2) + bin] += frame.weight_of(block, i);
    }
  }

  /// The item's key against that of the cut, in the first `count` components: -1, 0, 1.
  static int compare(const auto& keys, const Search& search, std::uint32_t count, std::size_t set, std::size_t i) {
    for (std::uint32_t c = 0; c < count; ++c) {
      const std::uint64_t key = c == 0 ? keys.first(set, i) : keys.component(set, i, c);
      if (key != search.at[c]) return key < search.at[c] ? -1 : 1;
    }
    return 0;
  }

  void apply_cuts(std::span<const ItemSet> sets) const {
    items_.for_chunks(items_.lanes(0), [&](std::size_t, const Chunk& chunk) {
      const std::span<std::uint32_t> targets = items_.blocks()[chunk.block].targets;
      const auto keys = keys_.reader(chunk.block);
      const std::uint32_t* set_of = set_of_.data();
      for (std::size_t i = chunk.begin; i < chunk.end; ++i) {
        const std::uint32_t s = set_of[targets[i] - range_.first];
        if (s == kNoSet) continue;
        const Search& search = sets[s].search;
        const bool right = search.component == 0 ? keys.first(s, i) >= search.at[0]
                                                 : compare(keys, search, search.component + 1, s, i) >= 0;
        targets[i] += right ? sets[s].left_count() : 0;
      }
    });
  }

  static std::vector<ItemSet> next_level(std::span<const ItemSet> sets) {
    std::vector<ItemSet> next;
    for (const ItemSet& set : sets)
      for (const ItemSet& half : halves(set))
        if (half.count > 1) next.push_back(half);
    return next;
  }

  const Items& items_;
  Keys& keys_;
  TargetRange range_;
  std::vector<std::uint32_t> set_of_;  // by label - range_.first
};

}  // namespace tetloom::balance_detail
