#pragma once
// Items sorted by what they belong to, by several threads.
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <span>

#include "tetloom/storage.hpp"

namespace tetloom {

/// The items of each of some groups, one group after the other; those of a group in any order. 4 bytes per item and 8
/// per group.
class Grouping {
 public:
  Grouping() = default;
  /// `for_each(visit)` calls visit(item, group) for all items, several at once if it likes, and the same ones whenever
  /// it is called. Pre: groups are below `group_count`.
  template <class ForEach>
  Grouping(std::size_t group_count, const ForEach& for_each) {
    // Counted, then placed from the ends to the begins. Partner of each access: the same for other items of the group.
    begins_.resize(group_count + 1, 0);
    for_each([&](std::uint32_t, std::size_t group) {
      std::atomic_ref(begins_[group]).fetch_add(1, std::memory_order_relaxed);
    });
    for (std::size_t g = 0; g < group_count; ++g) begins_[g + 1] += begins_[g];
    items_.resize_for_overwrite(begins_[group_count]);
    for_each([&](std::uint32_t item, std::size_t group) {
      items_[std::atomic_ref(begins_[group]).fetch_sub(1, std::memory_order_relaxed) - 1] = item;
    });
  }

  std::size_t size() const { return begins_.size() - 1; }
  std::span<const std::uint32_t> operator[](std::size_t group) const {
    return items_.span().subspan(begins_[group], begins_[group + 1] - begins_[group]);
  }

 private:
  GrowingArray<std::size_t> begins_;
  GrowingArray<std::uint32_t> items_;
};

}  // namespace tetloom
