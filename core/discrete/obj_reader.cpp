#include <charconv>
#include <cmath>
#include <unordered_map>

#include "core/discrete/facet_soup.hpp"
#include "core/discrete/polygon.hpp"
#include "core/discrete/text_cursor.hpp"

namespace tetloom::detail {
namespace {

class ObjParser {
 public:
  ObjParser(std::string_view text, const std::string& name, const CancelToken* cancel)
      : cursor_(text), text_(text), name_(name), cancel_(cancel) {}

  FacetSoup parse() {
    if (text_.find('\0') != text_.npos) fail("it holds bytes that no text has");
    std::size_t lines = 0;
    while (!cursor_.at_end()) {
      if (lines++ % kCancelEvery == 0) check_cancelled(cancel_);
      read_statement(cursor_.next_word_on_line());
      cursor_.rest_of_line();
    }
    if (!seen_keyword_) fail("it has no vertices and no facets");
    check_indices();
    return std::move(soup_);
  }

 private:
  [[noreturn]] void fail(const std::string& why) const {
    throw Error(ErrorCode::InputUnreadable,
                "'" + name_ + "' cannot be read as OBJ: " + why + " (line " + std::to_string(cursor_.line()) + ")");
  }

  void read_statement(std::string_view keyword) {
    if (keyword == "v") return read_vertex();
    if (keyword == "f" || keyword == "fo") return read_facet();
    if (keyword == "g") return start_group(group_);
    if (keyword == "o") return start_group(object_);
  }

  /// The next word of the statement, past a backslash at the end of a line.
  std::string_view next_word() {
    std::string_view word = cursor_.next_word_on_line();
    while (word == "\\") {
      cursor_.rest_of_line();
      word = cursor_.next_word_on_line();
    }
    return word;
  }

  void read_vertex() {
    seen_keyword_ = true;
    Vec3 point;
    for (int axis = 0; axis < 3; ++axis) {
      if (!parse_number(next_word(), point[axis])) fail("a vertex needs three numbers");
    }
    soup_.points.push_back(point);
  }

  /// "7", "7/1", "7//3", "7/1/3" or with negative numbers, which count back from the last vertex.
  std::uint32_t parse_index(std::string_view word) const {
    long long index = 0;
    const std::string_view number = word.substr(0, word.find('/'));
    const auto [end, error] = std::from_chars(number.data(), number.data() + number.size(), index);
    if (error != std::errc() || end != number.data() + number.size()) fail("a vertex number was expected");
    if (index < 0) index += static_cast<long long>(soup_.points.size()) + 1;
    if (index < 1 || index > 0xffffffffLL) fail("a facet refers to a vertex that does not exist");
    return static_cast<std::uint32_t>(index - 1);
  }

  void read_facet() {
    seen_keyword_ = true;
    polygon_.clear();
    for (std::string_view word = next_word(); !word.empty() && word[0] != '#'; word = next_word()) {
      polygon_.push_back(parse_index(word));
    }
    if (polygon_.size() < 3) fail("a facet has fewer than three vertices");
    add_polygon();
  }

  void add_polygon() {
    if (soup_.group_names.empty()) find_group();
    if (polygon_.size() == 3) return add_triangle({polygon_[0], polygon_[1], polygon_[2]});
    corners_.clear();
    for (const std::uint32_t vertex : polygon_) {
      if (vertex >= soup_.points.size()) fail("a polygon refers to a vertex that is not yet defined");
      corners_.push_back(soup_.points[vertex]);
    }
    for (const auto& t : triangulate_polygon(corners_)) add_triangle({polygon_[t[0]], polygon_[t[1]], polygon_[t[2]]});
  }

  void add_triangle(const Triangle& triangle) {
    soup_.tri_to_vert.push_back(triangle);
    soup_.tri_to_group.push_back(current_group_);
  }

  void start_group(std::string& group_or_object) {
    seen_keyword_ = true;
    group_or_object = cursor_.peek_rest_of_line();
    find_group();
  }

  void find_group() {
    const auto [entry, is_new] =
        key_to_group_.try_emplace(object_ + '\n' + group_, static_cast<std::uint32_t>(soup_.group_names.size()));
    current_group_ = entry->second;
    if (is_new) soup_.group_names.push_back(group_.empty() ? object_ : group_);
  }

  void check_indices() const {
    for (const Triangle& t : soup_.tri_to_vert) {
      for (const std::uint32_t vertex : t) {
        if (vertex >= soup_.points.size()) fail("a facet refers to a vertex that does not exist");
      }
    }
  }

  TextCursor cursor_;
  std::string_view text_;
  const std::string& name_;
  const CancelToken* cancel_;
  FacetSoup soup_;
  std::string group_, object_;
  std::unordered_map<std::string, std::uint32_t> key_to_group_;
  std::uint32_t current_group_ = 0;
  bool seen_keyword_ = false;
  std::vector<std::uint32_t> polygon_;
  std::vector<Vec3> corners_;
};

}  // namespace

FacetSoup parse_obj(std::string_view bytes, const std::string& name, const CancelToken* cancel) {
  return ObjParser(bytes, name, cancel).parse();
}

}  // namespace tetloom::detail
