#pragma once
// Private to core/io: the parts of the VTK XML format that reader and writer share, and decoded arrays.
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "core/io/formats_detail.hpp"

namespace tetloom::detail {

/// VTK's numbers for the types of cells.
inline constexpr std::uint8_t kVtkVertex = 1;
inline constexpr std::array<std::uint8_t, kBlocks> kVtkTypes{3, 5, 9, 10, 14, 13, 12};      ///< by Block
inline constexpr std::array<std::uint8_t, kBlocks> kVtkTypes2{21, 22, 23, 24, 27, 26, 25};  ///< of second order

/// VTK_WEDGE turns the other way than the prism of a Mesh. Goes both ways.
template <std::size_t N>
constexpr std::array<std::uint32_t, N> turned_for_vtk(const std::array<std::uint32_t, N>& v) {
  return v;
}
constexpr std::array<std::uint32_t, 6> turned_for_vtk(const std::array<std::uint32_t, 6>& v) {
  return {v[0], v[2], v[1], v[3], v[5], v[4]};
}

/// Names of the arrays with the entities of points and cells.
inline constexpr std::string_view kEntityDim = "entity_dim", kEntityTag = "entity_tag";
/// The array with the region of each cell, for viewers; 0 for edges and surface elements.
inline constexpr std::string_view kRegion = "region";
/// Whether an array of that name is no field.
constexpr bool is_classification(std::string_view name, bool of_points) {
  return name == kEntityDim || name == kEntityTag || (!of_points && name == kRegion);
}

/// The array with the global ids of the points of a piece. Fields are written as Float64, so the type tells them apart.
inline constexpr std::string_view kGlobalId = "global_id";
constexpr bool is_global_id(std::string_view name, std::string_view type) {
  return name == kGlobalId && type == "UInt64";
}
/// How many numbers a field may have for each point or cell.
inline constexpr std::size_t kMostVtuComponents = 1'000'000;

/// Text as it stands in an XML attribute, and back. Character references beyond ASCII are left as they are.
std::string xml_escaped(std::string_view text);
std::string xml_unescaped(std::string_view text);
/// What the arrays with the attributes of model entities start with.

/// One element, where its text lies in the file.
struct XmlElement {
  std::string_view name;
  std::vector<std::pair<std::string_view, std::string_view>> attributes;
  std::string_view text;  ///< up to the first tag inside
  std::vector<std::size_t> children;

  /// The value of an attribute, empty where it has none.
  std::string_view attribute(std::string_view key) const {
    for (const auto& [name_of_it, value] : attributes)
      if (name_of_it == key) return value;
    return {};
  }
};

/// The elements of a document, its root first. In the element AppendedData with raw encoding, which ends the document,
/// `text` runs to the end of the file.
std::vector<XmlElement> parse_xml(const InputFile& file);

/// A VTK number type.
enum class ScalarType { Int8, UInt8, Int16, UInt16, Int32, UInt32, Int64, UInt64, Float32, Float64 };
std::optional<ScalarType> scalar_type(std::string_view name);
std::size_t byte_size(ScalarType type);

/// An array of numbers of a type known at run time.
class VtuArray {
 public:
  VtuArray() = default;
  VtuArray(ScalarType type, std::string_view bytes, bool swap) : type_(type), swap_(swap), bytes_(bytes) {}
  VtuArray(ScalarType type, std::string&& bytes, bool swap) : type_(type), swap_(swap), owned_(std::move(bytes)) {}

  std::size_t byte_count() const { return bytes().size(); }
  std::size_t size() const { return bytes().size() / byte_size(type_); }
  bool is_integer() const { return type_ != ScalarType::Float32 && type_ != ScalarType::Float64; }
  double real(std::size_t i) const { return get<double>(i); }
  /// Of an integer array. Values beyond the range become negative.
  std::int64_t integer(std::size_t i) const { return get<std::int64_t>(i); }

 private:
  std::string_view bytes() const { return owned_.empty() ? bytes_ : std::string_view(owned_); }
  template <class To, class From>
  To load(std::size_t i) const {
    From value;
    std::memcpy(&value, bytes().data() + i * sizeof(From), sizeof(From));
    if constexpr (std::is_integral_v<To> && std::is_floating_point_v<From>)
      return 0;
    else
      return static_cast<To>(swap_ ? byte_swapped(value) : value);
  }
  template <class To>
  To get(std::size_t i) const {
    switch (type_) {
      case ScalarType::Int8: return load<To, std::int8_t>(i);
      case ScalarType::UInt8: return load<To, std::uint8_t>(i);
      case ScalarType::Int16: return load<To, std::int16_t>(i);
      case ScalarType::UInt16: return load<To, std::uint16_t>(i);
      case ScalarType::Int32: return load<To, std::int32_t>(i);
      case ScalarType::UInt32: return load<To, std::uint32_t>(i);
      case ScalarType::Int64: return load<To, std::int64_t>(i);
      case ScalarType::UInt64: return load<To, std::uint64_t>(i);
      case ScalarType::Float32: return load<To, float>(i);
      case ScalarType::Float64: return load<To, double>(i);
    }
    return {};
  }

  ScalarType type_ = ScalarType::UInt8;
  bool swap_ = false;
  std::string_view bytes_;
  std::string owned_;
};

/// Decodes DataArray elements of one document.
class VtuDecoder {
 public:
  VtuDecoder(const InputFile& file, const std::vector<XmlElement>& document);
  /// All numbers of `data_array`. Throws when all calls together give more than the size of the file can mean, as when
  /// many arrays claim the same data.
  VtuArray decode(const XmlElement& data_array);
  /// Throws where a file with raw data is cut off behind them.
  void check_tail() const;

 private:
  VtuArray decode_any(const XmlElement& element) const;
  std::uint64_t header_word(const char* at) const;
  VtuArray decode_text(const XmlElement& element, ScalarType type) const;
  VtuArray decode_raw(std::string_view data, ScalarType type) const;
  VtuArray decode_base64(std::string_view text, ScalarType type) const;
  std::string inflate(std::string_view header, std::string_view data) const;
  std::size_t compressed_header_bytes(std::string_view header) const;
  std::size_t compressed_data_bytes(std::string_view header) const;

  const InputFile& file_;
  bool swap_ = false, compressed_ = false, raw_ = false;
  std::size_t header_bytes_ = 4;
  std::uint64_t decoded_bytes_ = 0;  ///< by all calls
  std::string_view appended_;
};

}  // namespace tetloom::detail
