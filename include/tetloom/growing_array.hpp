#pragma once
// Arrays that grow without copying what they hold.
#include <algorithm>
#include <cstddef>
#include <initializer_list>
#include <span>
#include <type_traits>
#include <utility>

#include "tetloom/assert.hpp"

namespace tetloom {

namespace detail {

/// Resizes storage, keeping its first `used` bytes; nullptr stands for none on both sides. Large storage is a mapping
/// of its own: the system moves its pages to another address and copies nothing, and pages that were never touched
/// take no memory. Throws std::bad_alloc, and leaves the old storage as it was then.
void* resize_storage(void* storage, std::size_t old_bytes, std::size_t used, std::size_t new_bytes);

}  // namespace detail

/// A contiguous array of plain values, like std::vector but for this: growing moves pages instead of values, so that
/// it costs neither a copy nor a peak of memory, and room that is reserved but unused takes none. Small arrays lie on
/// the heap, so that thousands of parts with a few elements each are not rounded up to pages.
///
/// Addresses change when the array grows. Thread safety: as std::vector.
template <class T>
class GrowingArray {
  static_assert(std::is_trivially_copyable_v<T> && alignof(T) <= alignof(std::max_align_t));

 public:
  GrowingArray() = default;
  GrowingArray(std::initializer_list<T> values) { append(std::span<const T>(values.begin(), values.size())); }
  explicit GrowingArray(std::span<const T> values) { append(values); }
  GrowingArray(const GrowingArray& other) { append(other.span()); }
  GrowingArray(GrowingArray&& other) noexcept
      : data_(std::exchange(other.data_, nullptr)),
        size_(std::exchange(other.size_, 0)),
        capacity_(std::exchange(other.capacity_, 0)) {}
  GrowingArray& operator=(GrowingArray other) noexcept {
    std::swap(data_, other.data_);
    std::swap(size_, other.size_);
    std::swap(capacity_, other.capacity_);
    return *this;
  }
  ~GrowingArray() { set_capacity(0); }

  std::size_t size() const { return size_; }
  std::size_t capacity() const { return capacity_; }
  bool empty() const { return size_ == 0; }
  T* data() { return data_; }
  const T* data() const { return data_; }
  T* begin() { return data_; }
  T* end() { return data_ + size_; }
  const T* begin() const { return data_; }
  const T* end() const { return data_ + size_; }
  std::span<T> span() { return {data_, size_}; }
  std::span<const T> span() const { return {data_, size_}; }
  operator std::span<T>() { return span(); }
  operator std::span<const T>() const { return span(); }

  T& operator[](std::size_t i) {
    TETLOOM_DEBUG_ASSERT(i < size_);
    return data_[i];
  }
  const T& operator[](std::size_t i) const {
    TETLOOM_DEBUG_ASSERT(i < size_);
    return data_[i];
  }
  const T& back() const { return (*this)[size_ - 1]; }

  void reserve(std::size_t count) {
    if (count > capacity_) set_capacity(count);
  }
  /// New values are copies of `value`.
  void resize(std::size_t count, const T& value = T{}) {
    const std::size_t before = size_;
    const T copy = value;  // may lie in this array
    resize_for_overwrite(count);
    if (count > before) std::fill(data_ + before, data_ + count, copy);
  }
  /// New values hold anything.
  void resize_for_overwrite(std::size_t count) {
    if (count > capacity_) set_capacity(std::max(count, capacity_ + capacity_ / 2));
    size_ = count;
  }
  void push_back(const T& value) {
    const T copy = value;  // may lie in this array
    if (size_ == capacity_) [[unlikely]]
      grow();
    data_[size_++] = copy;
  }
  /// Pre: `values` does not lie in this array.
  void append(std::span<const T> values) {
    const std::size_t before = size_;
    if (before + values.size() > capacity_) reserve(std::max(before + values.size(), capacity_ + capacity_ / 2));
    size_ = before + values.size();
    std::copy(values.begin(), values.end(), data_ + before);
  }
  void clear() { size_ = 0; }
  /// Gives all memory back.
  void release() {
    size_ = 0;
    set_capacity(0);
  }
  void shrink_to_fit() {
    if (size_ < capacity_) set_capacity(size_);
  }

  friend bool operator==(const GrowingArray& a, const GrowingArray& b) {
    return std::equal(a.begin(), a.end(), b.begin(), b.end());
  }

 private:
  void grow() { set_capacity(std::max(size_ + 1, capacity_ + capacity_ / 2)); }
  void set_capacity(std::size_t count) {
    data_ = static_cast<T*>(
        detail::resize_storage(data_, capacity_ * sizeof(T), std::min(size_, count) * sizeof(T), count * sizeof(T)));
    capacity_ = count;
  }

  T* data_ = nullptr;
  std::size_t size_ = 0;
  std::size_t capacity_ = 0;
};

}  // namespace tetloom
