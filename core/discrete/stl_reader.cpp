#include <bit>
#include <cmath>
#include <cstring>

#include "core/discrete/facet_soup.hpp"
#include "core/discrete/text_cursor.hpp"

namespace tetloom::detail {
namespace {

constexpr std::size_t kHeaderBytes = 84, kFacetBytes = 50;

[[noreturn]] void fail_unreadable(const std::string& name, const std::string& why) {
  throw Error(ErrorCode::InputUnreadable, "'" + name + "' cannot be read as STL: " + why);
}

std::uint32_t little_endian_u32(const char* bytes) {
  std::array<unsigned char, 4> b;
  std::memcpy(b.data(), bytes, 4);
  return b[0] | std::uint32_t{b[1]} << 8 | std::uint32_t{b[2]} << 16 | std::uint32_t{b[3]} << 24;
}

double little_endian_float(const char* bytes) { return double{std::bit_cast<float>(little_endian_u32(bytes))}; }

std::uint64_t declared_binary_size(std::string_view bytes) {
  return kHeaderBytes + kFacetBytes * std::uint64_t{little_endian_u32(bytes.data() + 80)};
}

/// An exact size proves binary, for many binary files begin with "solid" too. Otherwise text that begins with "solid"
/// and has no zero byte near its start is ASCII.
bool looks_ascii(std::string_view bytes) {
  if (bytes.size() >= kHeaderBytes && declared_binary_size(bytes) == bytes.size()) return false;
  const std::string_view start = bytes.substr(0, 1024);
  if (start.find('\0') != start.npos) return false;
  return equals_ignoring_case(TextCursor(start).next_word().substr(0, 5), "solid");
}

FacetSoup parse_binary(std::string_view bytes, const std::string& name, const CancelToken* cancel) {
  if (bytes.size() < kHeaderBytes) fail_unreadable(name, "it is neither ASCII nor long enough for a binary header");
  const std::uint64_t declared = declared_binary_size(bytes);
  const std::size_t count = little_endian_u32(bytes.data() + 80);
  if (declared > bytes.size()) {
    fail_unreadable(name, "it is truncated or no STL file: " + std::to_string(count) + " facets need " +
                              std::to_string(declared) + " bytes, it has " + std::to_string(bytes.size()));
  }
  FacetSoup soup;
  if (declared < bytes.size()) {
    soup.remarks.push_back(std::to_string(bytes.size() - declared) + " bytes after the last facet were ignored");
  }
  soup.group_names.emplace_back();
  soup.points.reserve(3 * count), soup.tri_to_vert.reserve(count);
  for (std::size_t facet = 0; facet < count; ++facet) {
    if (facet % kCancelEvery == 0) check_cancelled(cancel);
    const char* at = bytes.data() + kHeaderBytes + kFacetBytes * facet + 12;
    for (int corner = 0; corner < 3; ++corner, at += 12) {
      soup.points.push_back({little_endian_float(at), little_endian_float(at + 4), little_endian_float(at + 8)});
    }
    const auto first = static_cast<std::uint32_t>(3 * facet);
    soup.tri_to_vert.push_back({first, first + 1, first + 2});
  }
  return soup;
}

/// The keywords of ASCII STL, one method each. "end solid", "end facet" and "end loop" are read as one word each. Where
/// only 'endsolid' is missing no facet is in doubt, so that is a remark and no error.
class AsciiParser {
 public:
  AsciiParser(std::string_view text, const std::string& name, const CancelToken* cancel)
      : cursor_(text), name_(name), cancel_(cancel) {}

  FacetSoup parse() {
    for (std::string_view word = cursor_.next_word(); !word.empty(); word = cursor_.next_word()) {
      if (is_trailer(word)) break;
      read(word);
    }
    if (in_facet_) fail("it is truncated: the last 'endfacet' is missing");
    if (in_solid_ && soup_.tri_to_vert.empty()) fail("it is truncated: the last 'endsolid' is missing");
    if (in_solid_) soup_.remarks.emplace_back("the last 'endsolid' is missing");
    return std::move(soup_);
  }

 private:
  [[noreturn]] void fail(const std::string& why) const {
    fail_unreadable(name_, why + " (line " + std::to_string(cursor_.line()) + ")");
  }

  /// Text after the last solid that starts no other one.
  bool is_trailer(std::string_view word) {
    if (in_solid_ || soup_.tri_to_vert.empty() || equals_ignoring_case(word, "solid")) return false;
    soup_.remarks.push_back("what follows the last solid was ignored, from line " + std::to_string(cursor_.line()) +
                            " on");
    return true;
  }

  void read(std::string_view word) {
    if (equals_ignoring_case(word, "end")) return read_end(cursor_.next_word_on_line());
    if (equals_ignoring_case(word, "vertex")) return read_vertex();
    if (equals_ignoring_case(word, "facet")) return read_facet_start();
    if (equals_ignoring_case(word, "outer") || equals_ignoring_case(word, "loop")) return;
    if (equals_ignoring_case(word, "endloop")) return;
    if (equals_ignoring_case(word, "endfacet")) return finish_facet();
    if (equals_ignoring_case(word, "solid")) return start_solid();
    if (equals_ignoring_case(word, "endsolid")) return finish_solid();
    fail("unexpected word '" + std::string(word.substr(0, 20)) + "'");
  }

  void read_end(std::string_view word) {
    if (equals_ignoring_case(word, "loop")) return;
    if (equals_ignoring_case(word, "facet")) return finish_facet();
    if (equals_ignoring_case(word, "solid") || word.empty()) return finish_solid();
    fail("unexpected word 'end " + std::string(word.substr(0, 20)) + "'");
  }

  double read_number() {
    double value = 0;
    const std::string_view word = cursor_.next_word();
    if (!parse_number(word, value)) fail("a number was expected");
    return value;
  }

  void read_vertex() {
    if (!in_facet_ || corners_ == 3)
      fail(in_facet_ ? "a facet has more than three vertices" : "a vertex lies outside of a facet");
    const double x = read_number(), y = read_number(), z = read_number();
    soup_.points.push_back({x, y, z});
    ++corners_;
  }

  void read_facet_start() {
    if (!in_solid_ || in_facet_) fail("a facet starts where none may");
    cursor_.rest_of_line();  // the normal is implied by the order of the vertices
    in_facet_ = true, corners_ = 0;
    if (soup_.tri_to_vert.size() % kCancelEvery == 0) check_cancelled(cancel_);
  }

  void finish_facet() {
    if (!in_facet_ || corners_ != 3) fail("a facet does not have three vertices");
    const auto end = static_cast<std::uint32_t>(soup_.points.size());
    soup_.tri_to_vert.push_back({end - 3, end - 2, end - 1});
    soup_.tri_to_group.push_back(static_cast<std::uint32_t>(soup_.group_names.size() - 1));
    in_facet_ = false;
  }

  void start_solid() {
    if (in_facet_) fail("a solid starts inside of a facet");
    if (in_solid_) soup_.remarks.push_back("an 'endsolid' is missing before line " + std::to_string(cursor_.line()));
    soup_.group_names.emplace_back(cursor_.rest_of_line());
    in_solid_ = true;
  }

  void finish_solid() {
    if (!in_solid_ || in_facet_) fail("a solid ends where none may");
    cursor_.rest_of_line();
    in_solid_ = false;
  }

  TextCursor cursor_;
  const std::string& name_;
  const CancelToken* cancel_;
  FacetSoup soup_;
  bool in_solid_ = false, in_facet_ = false;
  int corners_ = 0;
};

}  // namespace

FacetSoup parse_stl(std::string_view bytes, const std::string& name, const CancelToken* cancel) {
  constexpr std::string_view kByteOrderMark = "\xef\xbb\xbf";
  if (bytes.starts_with(kByteOrderMark) && looks_ascii(bytes.substr(3))) bytes.remove_prefix(3);
  if (looks_ascii(bytes)) return AsciiParser(bytes, name, cancel).parse();
  return parse_binary(bytes, name, cancel);
}

}  // namespace tetloom::detail
