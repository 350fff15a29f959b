#pragma once
// Private to core/io: writes HDF5 files, with no library. They have what releases 1.8 and later of HDF5 read: a
// superblock of version 2, groups that remember the order of their members, contiguous arrays. Object headers come
// first, arrays after them in the order in which they were added.
#include <cstdint>
#include <functional>
#include <map>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/io/atomic_file.hpp"

namespace tetloom::detail {

enum class Hdf5Type { Int8, UInt8, Int32, UInt32, Int64, Float32, Float64 };

template <class Value>
constexpr Hdf5Type hdf5_type_of();
template <>
constexpr Hdf5Type hdf5_type_of<std::int8_t>() {
  return Hdf5Type::Int8;
}
template <>
constexpr Hdf5Type hdf5_type_of<std::uint8_t>() {
  return Hdf5Type::UInt8;
}
template <>
constexpr Hdf5Type hdf5_type_of<std::int32_t>() {
  return Hdf5Type::Int32;
}
template <>
constexpr Hdf5Type hdf5_type_of<std::uint32_t>() {
  return Hdf5Type::UInt32;
}
template <>
constexpr Hdf5Type hdf5_type_of<std::int64_t>() {
  return Hdf5Type::Int64;
}
template <>
constexpr Hdf5Type hdf5_type_of<float>() {
  return Hdf5Type::Float32;
}
template <>
constexpr Hdf5Type hdf5_type_of<double>() {
  return Hdf5Type::Float64;
}

/// Objects have absolute paths, and parents are made before their members. Each path is used once.
class Hdf5Writer {
 public:
  using Fill = std::function<void(AtomicFile&)>;

  Hdf5Writer() { objects_.emplace_back(); }

  /// A group; those above it that are not there yet as well.
  void add_group(const std::string& path);
  /// Adds an array of numbers. `fill` appends its bytes to the file, in C order, when that is written.
  void add_array(const std::string& path, Hdf5Type type, std::vector<std::uint64_t> shape, Fill fill);
  /// Adds an array of one dimension with values that are copied.
  template <class Value>
  void add_values(const std::string& path, std::vector<Value> values) {
    const std::uint64_t count = values.size();
    add_array(path, hdf5_type_of<Value>(), {count}, [values = std::move(values)](AtomicFile& file) {
      file.write(values.data(), values.size() * sizeof(Value));
    });
  }
  /// Texts in arrays of `bytes` characters each, filled up with zeros.
  void add_characters(const std::string& path, const std::vector<std::string>& texts, std::size_t bytes);

  // Attributes of an object that is there.
  void put(const std::string& object, std::string_view name, std::int32_t value);
  void put(const std::string& object, std::string_view name, std::span<const std::int64_t> values);
  void put(const std::string& object, std::string_view name, std::span<const std::int32_t> values);
  void put(const std::string& object, std::string_view name, double value);
  /// Of text.size() bytes and a zero, or of `bytes`, where that is not 0: filled up with zeros or cut off.
  void put(const std::string& object, std::string_view name, const std::string& text, std::size_t bytes = 0);

  /// Writes the file. Errors: those of `file`.
  void write(AtomicFile& file) const;

 private:
  struct Member {
    std::string name;
    std::size_t object;
  };
  struct Object {
    std::string messages;         // encoded, but for links and the layout
    std::vector<Member> members;  // of a group
    bool is_array = false;
    std::uint64_t bytes = 0;  // of an array
    Fill fill;
  };

  Object& object_at(const std::string& path) { return objects_[paths_.at(path)]; }
  std::size_t add_object(const std::string& path);
  void add_array(const std::string& path, const std::string& type, std::size_t type_bytes,
                 std::span<const std::uint64_t> shape, Fill fill);
  void put_attribute(const std::string& object, std::string_view name, const std::string& type,
                     const std::string& space, std::string_view bytes);
  std::string header_of(const Object& object, std::span<const std::uint64_t> addresses, std::uint64_t data) const;

  std::vector<Object> objects_;  // the root first
  std::map<std::string, std::size_t, std::less<>> paths_{{"/", 0}};
};

}  // namespace tetloom::detail
