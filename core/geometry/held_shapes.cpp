#include "core/geometry/held_shapes.hpp"

#include <algorithm>
#include <utility>

namespace tetloom {

std::shared_ptr<const void> HeldShapes::get_any(std::size_t number, const std::function<Shape()>& make) {
  {
    const std::lock_guard lock(mutex_);
    if (const auto known = by_number_.find(number); known != by_number_.end()) {
      held_.splice(held_.begin(), held_, known->second);
      return known->second->shape.value;
    }
  }
  Shape made = make();
  const std::shared_ptr<const void> value = made.value;
  std::list<Held> dropped;  // destroyed behind the lock
  const std::lock_guard lock(mutex_);
  if (by_number_.contains(number)) return value;
  while (!held_.empty() && bytes_ + made.bytes > most_bytes_) {
    bytes_ -= held_.back().shape.bytes;
    by_number_.erase(held_.back().number);
    dropped.splice(dropped.begin(), held_, std::prev(held_.end()));
  }
  bytes_ += made.bytes;
  peak_bytes_ = std::max(peak_bytes_, bytes_);
  held_.push_front({number, std::move(made)});
  by_number_[number] = held_.begin();
  return value;
}

std::uint64_t HeldShapes::peak_bytes() const {
  const std::lock_guard lock(mutex_);
  return peak_bytes_;
}

}  // namespace tetloom
