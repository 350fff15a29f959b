#pragma once
// What one part sends to another in one step, and how values are put in and taken out.
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <type_traits>
#include <vector>

#include "core/base/error.hpp"
#include "core/base/ids.hpp"

namespace tetloom {

using PartId = Id<struct PartKind>;
using Bytes = std::vector<std::byte>;

/// `step` is the step that the message is for.
struct Message {
  PartId from, to;
  std::uint32_t step = 0;
  Bytes bytes;
};

/// Puts trivially copyable values and arrays into a buffer.
class MessageWriter {
 public:
  void reserve(std::size_t bytes) { bytes_.reserve(bytes); }
  bool empty() const { return bytes_.empty(); }

  template <class T>
  void put(const T& value) {
    put_raw(std::span<const T>(&value, 1));
  }
  /// The length and then the values.
  template <class T>
  void put_array(std::span<const T> values) {
    put(static_cast<std::uint64_t>(values.size()));
    put_raw(values);
  }
  Bytes take() { return std::move(bytes_); }

 private:
  template <class T>
  void put_raw(std::span<const T> values) {
    static_assert(std::is_trivially_copyable_v<T>);
    const auto raw = std::as_bytes(values);
    bytes_.insert(bytes_.end(), raw.begin(), raw.end());
  }
  Bytes bytes_;
};

/// Takes out in the same order what a MessageWriter put in. Throws Error(Internal) when there is less than asked for.
class MessageReader {
 public:
  explicit MessageReader(std::span<const std::byte> bytes) : bytes_(bytes) {}
  bool at_end() const { return bytes_.empty(); }

  template <class T>
  T get() {
    T value;
    get_raw(std::span<T>(&value, 1));
    return value;
  }
  template <class T>
  std::vector<T> get_array() {
    std::vector<T> values(count_of<T>());
    get_raw(std::span<T>(values));
    return values;
  }
  /// The same into an array of the caller's, which has the room; returns how many there were.
  template <class T>
  std::size_t get_array_into(std::span<T> room) {
    const std::size_t count = count_of<T>();
    if (count > room.size()) fail();
    get_raw(room.first(count));
    return count;
  }

 private:
  [[noreturn]] static void fail() {
    throw Error(ErrorCode::Internal, "a message between parts is shorter than it says");
  }
  template <class T>
  std::size_t count_of() {
    const auto count = get<std::uint64_t>();
    if (count > bytes_.size() / sizeof(T)) fail();
    return static_cast<std::size_t>(count);
  }
  template <class T>
  void get_raw(std::span<T> values) {
    static_assert(std::is_trivially_copyable_v<T>);
    if (values.size_bytes() > bytes_.size()) fail();
    if (!values.empty()) std::memcpy(values.data(), bytes_.data(), values.size_bytes());
    bytes_ = bytes_.subspan(values.size_bytes());
  }
  std::span<const std::byte> bytes_;
};

}  // namespace tetloom
