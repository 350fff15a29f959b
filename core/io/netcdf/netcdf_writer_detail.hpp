#pragma once
// Private to core/io: writes netCDF files of the classic forms, with no library ("The NetCDF Classic Format
// Specification", Unidata): a head that lists dimensions, attributes and variables, then the variables one after the
// other, all big-endian.
#include <cstdint>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "core/io/atomic_file.hpp"
#include "core/io/input_detail.hpp"

namespace tetloom::detail {

/// By the number that files have for it.
enum class NetcdfType : std::uint8_t { Char = 2, Int32 = 4, Float32 = 5, Float64 = 6 };

/// By the number behind "CDF". Every program that knows netCDF reads the first, where no variable may have 4 GiB.
enum class NetcdfForm : std::uint8_t { Offset64 = 2, Data64 = 5 };

/// Appends value(i) for 0 <= i < count as netCDF has numbers.
template <class ValueOf>
void put_big_endian(AtomicFile& file, std::size_t count, const ValueOf& value, const BlockLoop& loop) {
  file.put_each(
      count, [&](std::size_t i) { return byte_swapped(value(i)); }, loop);
}

/// Writes the dimensions, variables and attributes of a netCDF file.
class NetcdfWriter {
 public:
  using Fill = std::function<void(AtomicFile&)>;
  using Dimension = std::size_t;
  using Dimensions = std::vector<Dimension>;

  /// Pre: length > 0; the name is no other dimension's.
  Dimension add_dimension(const std::string& name, std::uint64_t length);
  /// A dimension that could grow, and has no length yet; one at most. Variables that have it have it first.
  Dimension add_growing_dimension(const std::string& name);

  // Attributes of the whole file.
  void put(const std::string& name, std::int32_t value);
  void put(const std::string& name, float value);
  void put(const std::string& name, const std::string& text);

  /// `fill` appends the values to the file when that is written. Pre: the name is no other variable's.
  void add_variable(const std::string& name, NetcdfType type, const Dimensions& dimensions, Fill fill = {});
  /// The same with values that are copied.
  void add_integers(const std::string& name, Dimension dimension, std::vector<std::int32_t> values);
  /// The same with texts, filled up with zeros. Pre: each is shorter than the dimension `width`.
  void add_texts(const std::string& name, Dimension count, Dimension width, const std::vector<std::string>& texts);
  /// An attribute of the variable that was added last.
  void put_on_variable(const std::string& name, const std::string& text);

  /// The first form that holds all variables.
  NetcdfForm needed_form() const;
  /// Pre: `form` holds all variables. Errors: those of `file`.
  void write(AtomicFile& file, NetcdfForm form) const;

 private:
  struct NamedLength {
    std::string name;
    std::uint64_t length;  // 0: it grows
  };
  struct Attribute {
    std::string name;
    NetcdfType type;
    std::uint64_t count;
    std::string bytes;  // as in the file
  };
  struct Variable {
    std::string name;
    NetcdfType type;
    Dimensions dimensions;
    std::vector<Attribute> attributes;
    Fill fill;
  };
  class Head;

  bool grows(const Variable& variable) const;
  std::uint64_t bytes_of(const Variable& variable) const;  // of one record where it grows
  std::string make_head(NetcdfForm form, const std::vector<std::uint64_t>& begins) const;

  std::vector<NamedLength> dimensions_;
  std::vector<Attribute> attributes_;
  std::vector<Variable> variables_;
};

}  // namespace tetloom::detail
