#pragma once
// Private to core/mesh: sums, sums per model entity and quantiles, put together from those of blocks.
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/base/lists.hpp"
#include "tetloom/host.hpp"

namespace tetloom::detail {

/// Sum with the rounding errors carried along (Neumaier 1974), so that it does not drift over many millions of terms.
class Sum {
 public:
  void add(double x) {
    const double next = total_ + x;
    lost_ += std::abs(total_) >= std::abs(x) ? (total_ - next) + x : (x - next) + total_;
    total_ = next;
  }
  void add(const Sum& other) {
    add(other.total_);
    lost_ += other.lost_;
  }
  double value() const { return total_ + lost_; }

 private:
  double total_ = 0, lost_ = 0;
};

/// Entries per entity index, ascending, found without trusting that indices are small. `Entry` has add(Entry).
template <class Entry>
class PerEntity {
 public:
  struct Item {
    std::uint32_t entity;
    Entry entry;
  };

  PerEntity() = default;
  /// With blank entries for the entities of some elements.
  explicit PerEntity(std::span<const std::uint32_t> element_to_entity) {
    std::vector<std::uint32_t> keys;
    for (const std::uint32_t entity : element_to_entity)
      if (keys.empty() || keys.back() != entity) keys.push_back(entity);
    sort_unique(keys);
    for (const std::uint32_t entity : keys) items_.push_back({entity, {}});
  }

  /// Elements of an entity tend to follow each other, so the last entry is tried first. Pre: there is one.
  Entry& at(std::uint32_t entity) {
    if (items_[last_].entity != entity) last_ = place_of(entity);
    return items_[last_].entry;
  }
  /// Adds all entries of another one, new entities too.
  void add(const PerEntity& other) {
    for (const Item& item : other.items_) {
      const std::size_t place = place_of(item.entity);
      if (place == items_.size() || items_[place].entity != item.entity)
        items_.insert(items_.begin() + static_cast<std::ptrdiff_t>(place), item);
      else
        items_[place].entry.add(item.entry);
    }
  }
  const std::vector<Item>& items() const { return items_; }

 private:
  std::size_t place_of(std::uint32_t entity) const {
    const auto place = std::lower_bound(items_.begin(), items_.end(), entity,
                                        [](const Item& item, std::uint32_t wanted) { return item.entity < wanted; });
    return static_cast<std::size_t>(place - items_.begin());
  }

  std::vector<Item> items_;
  std::size_t last_ = 0;
};

/// The `share` quantile of `values`, interpolated linearly between its neighbours; 0 of none. Quick where the values
/// spread over [0, 1].
double quantile(std::span<const float> values, double share, const BlockLoop& loop);

}  // namespace tetloom::detail
