#pragma once
// Filing items under ranges of keys, so that each range can be worked on by itself, with a working
// memory that is bounded whatever the size of the mesh.
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "tetloom/host.hpp"

namespace tetloom {

/// Equal ranges of the keys 0, ..., keys - 1. How wide they are depends on the number of keys alone.
class KeyRanges {
 public:
  explicit KeyRanges(std::size_t keys) : keys_(keys) {
    while (count() > kMost) ++shift_;
  }
  std::size_t count() const { return (keys_ + (std::size_t{1} << shift_) - 1) >> shift_; }
  std::size_t of(std::size_t key) const { return key >> shift_; }
  std::size_t first(std::size_t range) const { return range << shift_; }
  std::size_t last(std::size_t range) const { return std::min(keys_, (range + 1) << shift_); }

 private:
  static constexpr std::size_t kMost = 2048;
  std::size_t keys_;
  unsigned shift_ = 11;  // what lies around 2048 points stays in the cache of a core
};

/// Consecutive groups [first, last) whose counts add up to at most `limit`, or which hold a single one; those where all
/// counts are zero are left out.
struct FilingWindow {
  std::size_t first = 0, last = 0;
  std::size_t uses = 0;
};
std::vector<FilingWindow> cut_filing_windows(std::span<const std::size_t> counts, std::size_t limit);

/// How many items of each range every block of sources files, and then where the next of them goes.
class FilingPlan {
 public:
  FilingPlan(std::size_t sources, std::size_t ranges)
      : grain_(std::max(kLeastGrain, (sources + kMostBlocks - 1) / kMostBlocks)),
        ranges_(ranges),
        places_((sources + grain_ - 1) / grain_ * ranges, 0) {}

  std::size_t grain() const { return grain_; }
  /// The places of the block that starts at the source `begin`, by range.
  std::size_t* row(std::size_t begin) { return places_.data() + begin / grain_ * ranges_; }
  /// How many items each range has.
  std::vector<std::size_t> totals() const;
  /// Turns the counts of a window into places, range by range and within a range block by block; the ends of the ranges
  /// are returned.
  std::vector<std::size_t> lay_out(const FilingWindow& window);

 private:
  static constexpr std::size_t kLeastGrain = std::size_t{1} << 15, kMostBlocks = 512;
  std::size_t grain_, ranges_;
  std::vector<std::size_t> places_;
};

/// Calls emit(begin, end, file) for blocks of the sources [0, count), which calls file(range, item) for everything in
/// them; then visit(range, items) for every range that has some, with its items in the order of the sources. Blocks and
/// ranges are worked on several at once where `loop` does so. `emit` is called several times for each block and files
/// the same then. At most `limit` items, or those of one range, are held at a time.
template <class Item, class Emit, class Visit>
void for_each_filed_range(std::size_t count, const KeyRanges& ranges, const BlockLoop& loop, const Emit& emit,
                          const Visit& visit, std::size_t limit = (std::size_t{1} << 27) / sizeof(Item)) {
  FilingPlan plan(count, ranges.count());
  loop.for_blocks(count, plan.grain(), [&](std::size_t begin, std::size_t end) {
    std::size_t* counts = plan.row(begin);
    emit(begin, end, [counts](std::size_t range, const Item&) { ++counts[range]; });
  });
  const std::vector<FilingWindow> windows = cut_filing_windows(plan.totals(), limit);
  std::size_t most = 0;
  for (const FilingWindow& window : windows) most = std::max(most, window.uses);
  const auto items = std::make_unique_for_overwrite<Item[]>(most);
  for (const FilingWindow& window : windows) {
    const std::vector<std::size_t> ends = plan.lay_out(window);
    loop.for_blocks(count, plan.grain(), [&](std::size_t begin, std::size_t end) {
      std::size_t* next = plan.row(begin);
      emit(begin, end, [&](std::size_t range, const Item& item) {
        if (range - window.first < ends.size()) items[next[range]++] = item;  // wraps below the window
      });
    });
    loop.for_blocks(ends.size(), 1, [&](std::size_t i, std::size_t) {
      const std::size_t begin = i == 0 ? 0 : ends[i - 1];
      if (begin < ends[i]) visit(window.first + i, std::span<Item>(items.get() + begin, items.get() + ends[i]));
    });
  }
}

}  // namespace tetloom
