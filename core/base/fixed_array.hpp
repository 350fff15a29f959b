#pragma once
// Arrays whose values do not change, and which may lie where others have them too.
#include <cstddef>
#include <functional>
#include <memory>
#include <span>
#include <type_traits>
#include <utility>
#include <vector>

namespace tetloom {

/// Keeps a copy of some bytes, for as long as somebody holds it; null where it does not.
using KeepBytes = std::function<std::shared_ptr<const std::byte>(std::span<const std::byte>)>;

/// Values in a vector of their own, or in bytes that somebody keeps. Copies share them.
template <class T>
class FixedArray {
  static_assert(std::is_trivially_copyable_v<T>);

 public:
  FixedArray() = default;
  explicit FixedArray(std::vector<T> values) {
    auto own = std::make_shared<const std::vector<T>>(std::move(values));
    values_ = *own;
    holder_ = std::move(own);
  }

  const T& operator[](std::size_t i) const { return values_[i]; }
  const T* data() const { return values_.data(); }
  std::size_t size() const { return values_.size(); }
  bool empty() const { return values_.empty(); }
  std::span<const T> span() const { return values_; }

  /// From now on the values are those that `keep` keeps, where it does.
  void move_to(const KeepBytes& keep) {
    std::shared_ptr<const std::byte> kept = keep(std::as_bytes(values_));
    if (!kept) return;
    values_ = {reinterpret_cast<const T*>(kept.get()), values_.size()};
    holder_ = std::move(kept);
  }

 private:
  std::shared_ptr<const void> holder_;
  std::span<const T> values_;
};

}  // namespace tetloom
