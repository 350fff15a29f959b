#pragma once
// What one part sends to another in one step, and how values are put in and taken out.
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <type_traits>
#include <utility>
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
  Bytes take() { return std::move(bytes_); }

 private:
  template <class T>
  std::span<T> make_room(std::size_t count) {
    static_assert(std::is_trivially_copyable_v<T> && alignof(T) <= 8);
    const std::size_t before = bytes_.size();
    bytes_.resize(before + (count * sizeof(T) + 7) / 8 * 8);
    return {reinterpret_cast<T*>(bytes_.data() + before), count};
  }
  Bytes bytes_;
};

/// Takes out in the same order what a MessageWriter put in. Throws Error(Internal) when there is less than asked for.
/// Pre: the bytes begin at a multiple of 8.
class MessageReader {
 public:
  explicit MessageReader(std::span<const std::byte> bytes) : bytes_(bytes) {}
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
  [[noreturn]] static void fail() {
    throw Error(ErrorCode::Internal, "a message between parts is shorter than it says");
  }
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
