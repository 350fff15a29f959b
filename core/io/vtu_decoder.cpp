// DataArray elements in all encodings that VTK writes ("VTK XML Formats", docs.vtk.org): text, base64 in place or
// appended, raw appended; as they are or in blocks compressed by zlib.
#include <zlib.h>

#include <array>
#include <limits>

#include "core/io/vtu_detail.hpp"

namespace tetloom::detail {
namespace {

constexpr std::array<std::pair<std::string_view, ScalarType>, 10> kScalarNames{{{"Int8", ScalarType::Int8},
                                                                                {"UInt8", ScalarType::UInt8},
                                                                                {"Int16", ScalarType::Int16},
                                                                                {"UInt16", ScalarType::UInt16},
                                                                                {"Int32", ScalarType::Int32},
                                                                                {"UInt32", ScalarType::UInt32},
                                                                                {"Int64", ScalarType::Int64},
                                                                                {"UInt64", ScalarType::UInt64},
                                                                                {"Float32", ScalarType::Float32},
                                                                                {"Float64", ScalarType::Float64}}};

/// zlib shrinks nothing to less than a thousandth: larger claims are wrong and not worth allocating for.
constexpr std::uint64_t kLargestRatioOfZlib = 1100;

int base64_value(char c) {
  if (c >= 'A' && c <= 'Z') return c - 'A';
  if (c >= 'a' && c <= 'z') return c - 'a' + 26;
  if (c >= '0' && c <= '9') return c - '0' + 52;
  return c == '+' ? 62 : c == '/' ? 63 : -1;
}

/// The first `size` bytes of base64 text, fewer where it ends before. Padding ends a run of groups and another run may
/// follow, as VTK encodes a header apart from its data.
std::string from_base64(std::string_view text, std::size_t size) {
  std::string bytes;
  // Never more than the text can give, whatever the file says.
  bytes.reserve(std::min(size, text.size() / 4 * 3 + 3) + 3);
  unsigned group = 0;
  int digits = 0;
  for (const char c : text) {
    if (bytes.size() >= size) break;
    if (c == '=') {
      if (digits >= 2) bytes += static_cast<char>(digits == 2 ? group >> 4 : group >> 10);
      if (digits == 3) bytes += static_cast<char>(group >> 2);
      digits = 0, group = 0;
      continue;
    }
    const int value = base64_value(c);
    if (value < 0) continue;  // white space
    group = (group << 6) | static_cast<unsigned>(value);
    if (++digits < 4) continue;
    for (const int shift : {16, 8, 0}) bytes += static_cast<char>(group >> shift);
    digits = 0, group = 0;
  }
  if (bytes.size() > size) bytes.resize(size);
  return bytes;
}

template <class Number>
void append_number(std::string& bytes, Number value) {
  bytes.append(reinterpret_cast<const char*>(&value), sizeof(Number));
}

}  // namespace

std::optional<ScalarType> scalar_type(std::string_view name) {
  for (const auto& [known, type] : kScalarNames)
    if (known == name) return type;
  return {};
}

std::size_t byte_size(ScalarType type) {
  switch (type) {
    case ScalarType::Int8:
    case ScalarType::UInt8: return 1;
    case ScalarType::Int16:
    case ScalarType::UInt16: return 2;
    case ScalarType::Int32:
    case ScalarType::UInt32:
    case ScalarType::Float32: return 4;
    case ScalarType::Int64:
    case ScalarType::UInt64:
    case ScalarType::Float64: return 8;
  }
  return 8;
}

VtuDecoder::VtuDecoder(const InputFile& file, const std::vector<XmlElement>& document) : file_(file) {
  const XmlElement& root = document.front();
  swap_ = root.attribute("byte_order") == "BigEndian";
  header_bytes_ = root.attribute("header_type") == "UInt64" ? 8 : 4;
  const std::string_view compressor = root.attribute("compressor");
  compressed_ = !compressor.empty();
  if (compressed_ && compressor != "vtkZLibDataCompressor")
    file.fail(ErrorCode::InputUnsuitable, "data compressed by " + std::string(compressor) + " are not supported");
  for (const XmlElement& element : document) {
    if (element.name != "AppendedData") continue;
    raw_ = element.attribute("encoding") == "raw";
    const std::size_t begin = element.text.find('_');  // the data start behind it
    if (begin == std::string_view::npos) file.fail("appended data without '_'", element.text.data());
    appended_ = element.text.substr(begin + 1);
  }
}

void VtuDecoder::check_tail() const {
  constexpr std::size_t kLongestTail = 200;
  if (!raw_) return;
  const std::string_view tail = appended_.substr(appended_.size() - std::min(kLongestTail, appended_.size()));
  if (tail.find("</VTKFile>") == std::string_view::npos)
    file_.fail("the file ends too early", appended_.data() + appended_.size());
}

VtuArray VtuDecoder::decode(const XmlElement& element) {
  file_.check_cancelled();
  VtuArray array = decode_any(element);
  decoded_bytes_ += array.byte_count();
  // A digit and a space may stand for eight bytes.
  const std::uint64_t largest_ratio = compressed_ ? kLargestRatioOfZlib : 8;
  if (decoded_bytes_ / largest_ratio > file_.bytes().size())
    file_.fail_at_line("the arrays claim more data than the file can hold", element.name.data());
  return array;
}

VtuArray VtuDecoder::decode_any(const XmlElement& element) const {
  const std::string name(element.attribute("Name"));
  const std::optional<ScalarType> type = scalar_type(element.attribute("type"));
  if (!type) file_.fail_at_line("the array '" + name + "' has an unknown type", element.name.data());
  const std::string_view format = element.attribute("format");
  if (format == "ascii" || format.empty()) return decode_text(element, *type);
  if (format == "binary") return decode_base64(element.text, *type);
  if (format != "appended") file_.fail_at_line("the array '" + name + "' has an unknown format", element.name.data());
  std::uint64_t offset = 0;
  const std::string_view digits = element.attribute("offset");
  const auto result = std::from_chars(digits.data(), digits.data() + digits.size(), offset);
  if (result.ec != std::errc() || offset > appended_.size())
    file_.fail_at_line("the data of the array '" + name + "' lie outside of the file", element.name.data());
  const std::string_view data = appended_.substr(offset);
  return raw_ ? decode_raw(data, *type) : decode_base64(data, *type);
}

std::uint64_t VtuDecoder::header_word(const char* at) const {
  if (header_bytes_ == 8) {
    std::uint64_t value;
    std::memcpy(&value, at, 8);
    return swap_ ? byte_swapped(value) : value;
  }
  std::uint32_t value;
  std::memcpy(&value, at, 4);
  return swap_ ? byte_swapped(value) : value;
}

VtuArray VtuDecoder::decode_text(const XmlElement& element, ScalarType type) const {
  const bool real = type == ScalarType::Float32 || type == ScalarType::Float64;
  std::string bytes;
  Cursor cursor(file_, element.text);
  for (cursor.skip_space(); cursor.left() > 0; cursor.skip_space())
    if (real)
      append_number(bytes, cursor.parse<double>());
    else
      append_number(bytes, cursor.parse<std::int64_t>());
  return VtuArray(real ? ScalarType::Float64 : ScalarType::Int64, std::move(bytes), false);
}

/// The header of compressed data: number of blocks, their size, the size of the last one, and their compressed sizes.
std::size_t VtuDecoder::compressed_header_bytes(std::string_view header) const {
  const std::uint64_t blocks = header_word(header.data());
  if (blocks > file_.bytes().size()) file_.fail(ErrorCode::InputUnreadable, "an array has too many compressed blocks");
  return (3 + static_cast<std::size_t>(blocks)) * header_bytes_;
}

std::size_t VtuDecoder::compressed_data_bytes(std::string_view header) const {
  std::size_t sum = 0;
  for (std::size_t at = 3 * header_bytes_; at < header.size(); at += header_bytes_) {
    const std::uint64_t size = header_word(header.data() + at);
    if (size > file_.bytes().size() - std::min(sum, file_.bytes().size()))
      file_.fail(ErrorCode::InputUnreadable, "a compressed array exceeds the file");
    sum += static_cast<std::size_t>(size);
  }
  return sum;
}

VtuArray VtuDecoder::decode_raw(std::string_view data, ScalarType type) const {
  const auto expect = [&](std::uint64_t size) {
    if (size > data.size()) file_.fail("an array exceeds the file", data.data());
  };
  expect(header_bytes_);
  if (!compressed_) {
    const std::uint64_t size = header_word(data.data());
    expect(header_bytes_), data.remove_prefix(header_bytes_);
    expect(size);
    return VtuArray(type, data.substr(0, static_cast<std::size_t>(size)), swap_);
  }
  const std::size_t header_size = compressed_header_bytes(data);
  expect(header_size);
  const std::string_view header = data.substr(0, header_size);
  data.remove_prefix(header_size);
  expect(compressed_data_bytes(header));
  return VtuArray(type, inflate(header, data), swap_);
}

VtuArray VtuDecoder::decode_base64(std::string_view text, ScalarType type) const {
  const auto take = [&](std::size_t size) {
    std::string bytes = from_base64(text, size);
    if (bytes.size() < size) file_.fail_at_line("an array ends too early", text.data() + text.size());
    return bytes;
  };
  const std::string first = take(header_bytes_);
  if (!compressed_) {
    const std::uint64_t size = header_word(first.data());
    if (size > text.size()) file_.fail_at_line("an array exceeds the file", text.data());
    std::string bytes = take(header_bytes_ + static_cast<std::size_t>(size));
    bytes.erase(0, header_bytes_);
    return VtuArray(type, std::move(bytes), swap_);
  }
  const std::size_t header_size = compressed_header_bytes(first);
  const std::string header = take(header_size);
  const std::string all = take(header_size + compressed_data_bytes(header));
  return VtuArray(type, inflate(header, std::string_view(all).substr(header_size)), swap_);
}

std::string VtuDecoder::inflate(std::string_view header, std::string_view data) const {
  const auto word = [&](std::size_t i) { return header_word(header.data() + i * header_bytes_); };
  const std::uint64_t blocks = word(0), block_size = word(1), last_size = word(2);
  std::string bytes;
  for (std::uint64_t block = 0; block < blocks; ++block) {
    const auto packed = static_cast<std::size_t>(word(3 + block));
    const std::uint64_t size = block + 1 == blocks && last_size > 0 ? last_size : block_size;
    if (size / kLargestRatioOfZlib > packed || packed > data.size())
      file_.fail(ErrorCode::InputUnreadable, "a compressed block cannot hold what it claims to");
    const std::size_t begin = bytes.size();
    bytes.resize(begin + static_cast<std::size_t>(size));
    auto unpacked = static_cast<uLongf>(size);
    const int status = ::uncompress(reinterpret_cast<Bytef*>(bytes.data() + begin), &unpacked,
                                    reinterpret_cast<const Bytef*>(data.data()), static_cast<uLong>(packed));
    if (status != Z_OK || unpacked != size) file_.fail(ErrorCode::InputUnreadable, "a compressed block is damaged");
    data.remove_prefix(packed);
  }
  return bytes;
}

}  // namespace tetloom::detail
