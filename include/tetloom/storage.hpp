#pragma once
// Arrays that grow without copying what they hold, and values packed into bytes.
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <initializer_list>
#include <iterator>
#include <span>
#include <type_traits>
#include <utility>
#include <vector>

#include "tetloom/assert.hpp"
#include "tetloom/error.hpp"

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
  explicit GrowingArray(std::size_t count, const T& value = T{}) { resize(count, value); }
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

// Values packed into bytes, for messages and files.

using Bytes = GrowingArray<std::byte>;

/// Puts trivially copyable values and arrays into a buffer, each at a multiple of 8 bytes.
class MessageWriter {
 public:
  void reserve(std::size_t bytes) { bytes_.reserve(bytes); }
  bool empty() const { return bytes_.empty(); }

  template <class T>
  void put(const T& value) {
    std::memcpy(make_room<T>(1).data(), &value, sizeof(T));
  }
  /// The length and then the values.
  template <class T>
  void put_array(std::span<const T> values) {
    const std::span<T> room = put_room<T>(values.size());
    if (!values.empty()) std::memcpy(room.data(), values.data(), values.size_bytes());
  }
  /// The length, and room for the values that the caller fills in before anything else is put.
  template <class T>
  std::span<T> put_room(std::size_t count) {
    put(static_cast<std::uint64_t>(count));
    return make_room<T>(count);
  }
  /// The length, and `value(item)` for each of the items.
  template <class Items, class Value>
  void put_each(const Items& items, const Value& value) {
    using T = std::decay_t<decltype(value(*std::begin(items)))>;
    std::ranges::transform(items, put_room<T>(std::size(items)).begin(), value);
  }
  Bytes take() { return std::move(bytes_); }

 private:
  template <class T>
  std::span<T> make_room(std::size_t count) {
    static_assert(std::is_trivially_copyable_v<T> && alignof(T) <= 8);
    const std::size_t before = bytes_.size(), used = before + count * sizeof(T);
    bytes_.resize_for_overwrite((used + 7) / 8 * 8);
    std::fill(bytes_.begin() + used, bytes_.end(), std::byte{});
    return {reinterpret_cast<T*>(bytes_.data() + before), count};
  }
  Bytes bytes_;
};

/// Takes out in the same order what a MessageWriter put in. Throws Error(Internal) when there is less than asked for.
/// Pre: the bytes begin at a multiple of 8.
class MessageReader {
 public:
  explicit MessageReader(std::span<const std::byte> bytes) : bytes_(bytes) {}
  explicit MessageReader(const Bytes& bytes) : bytes_(bytes.span()) {}
  bool at_end() const { return bytes_.empty(); }

  template <class T>
  T get() {
    T value;
    std::memcpy(&value, take<T>(1).data(), sizeof(T));
    return value;
  }
  /// The values where they lie; valid as long as the bytes are.
  template <class T>
  std::span<const T> get_view() {
    const auto count = get<std::uint64_t>();
    if (count > bytes_.size() / sizeof(T)) fail();
    return take<T>(static_cast<std::size_t>(count));
  }
  template <class T>
  std::vector<T> get_array() {
    const std::span<const T> view = get_view<T>();
    return {view.begin(), view.end()};
  }

 private:
  [[noreturn]] static void fail() { throw Error(ErrorCode::Internal, "packed values are shorter than they say"); }
  template <class T>
  std::span<const T> take(std::size_t count) {
    static_assert(std::is_trivially_copyable_v<T> && alignof(T) <= 8);
    const std::size_t padded = (count * sizeof(T) + 7) / 8 * 8;
    if (padded > bytes_.size()) fail();
    const std::span<const T> values(reinterpret_cast<const T*>(bytes_.data()), count);
    bytes_ = bytes_.subspan(padded);
    return values;
  }
  std::span<const std::byte> bytes_;
};

}  // namespace tetloom
