#pragma once
// Numbers for the few of many items that something uses.
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "tetloom/ids.hpp"

namespace tetloom {

/// Gives consecutive numbers to items, in the order in which they are added. Beginning anew costs what was added, so
/// one object serves many small tasks.
class LocalNumbers {
 public:
  /// Items are below `item_count`.
  explicit LocalNumbers(std::size_t item_count = 0) : numbers_(item_count, kNone) {}

  /// The number of an item, the next one where it has none.
  std::uint32_t add(std::uint32_t item) {
    std::uint32_t& number = numbers_[item];
    if (number == kNone) {
      number = static_cast<std::uint32_t>(items_.size());
      items_.push_back(item);
    }
    return number;
  }
  /// kNone where it has none.
  std::uint32_t operator[](std::uint32_t item) const { return numbers_[item]; }

  std::size_t size() const { return items_.size(); }
  /// By their numbers.
  std::span<const std::uint32_t> items() const { return items_; }

  /// Items are below `item_count` from now on. Pre: no item beyond has a number.
  void set_item_count(std::size_t item_count) { numbers_.resize(item_count, kNone); }
  /// Numbers what has been added anew, in ascending order.
  void sort() {
    constexpr std::size_t kFew = 16;
    if (items_.size() < numbers_.size() / kFew) {
      std::ranges::sort(items_);
    } else {
      items_.clear();
      for (std::uint32_t item = 0; item < numbers_.size(); ++item)
        if (numbers_[item] != kNone) items_.push_back(item);
    }
    for (std::uint32_t i = 0; i < items_.size(); ++i) numbers_[items_[i]] = i;
  }
  /// No item has a number any more.
  void clear() {
    for (const std::uint32_t item : items_) numbers_[item] = kNone;
    items_.clear();
  }

 private:
  std::vector<std::uint32_t> numbers_, items_;
};

}  // namespace tetloom
