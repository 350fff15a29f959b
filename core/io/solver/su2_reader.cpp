// Meshes of SU2: one zone, in two dimensions (a surface at z = 0 then) or three. Markers become model faces, or model
// edges in two dimensions. Numbers behind elements and points are passed over: they count in the order of the file.
#include <algorithm>
#include <cctype>
#include <charconv>
#include <optional>

#include "core/io/formats_detail.hpp"
#include "core/io/solver/group_tags.hpp"
#include "core/io/vtu_detail.hpp"

namespace tetloom::detail {
namespace {

class Su2Reader {
 public:
  explicit Su2Reader(const InputFile& file) : file_(file), cursor_(file, file.bytes()) {}

  Mesh read() {
    while (next_line()) {
      const std::string key = take_key();
      if (key == "NDIME") {
        dim_ = number<int>();
        if (dim_ != 2 && dim_ != 3) file_.fail_at_line("NDIME must be 2 or 3", line_.data());
      } else if (key == "NZONE") {
        if (number<int>() != 1) file_.fail(ErrorCode::InputUnsuitable, "a mesh of several zones");
      } else if (key == "NELEM") {
        read_elements(number<std::uint64_t>(), {});
      } else if (key == "NPOIN") {
        read_points(number<std::uint64_t>());
      } else if (key == "MARKER_TAG") {
        marker_ = groups().find(word());
      } else if (key == "MARKER_ELEMS") {
        if (!marker_) file_.fail_at_line("MARKER_ELEMS without a MARKER_TAG", line_.data());
        read_elements(number<std::uint64_t>(), marker_);
      }
    }
    return finish();
  }

 private:
  // The next line that says something; false at the end of the file.
  bool next_line() {
    while (cursor_.left() > 0) {
      line_ = cursor_.line();
      line_ = line_.substr(0, line_.find('%'));
      skip_space();
      if (!line_.empty()) return true;
    }
    return false;
  }
  void skip_space() {
    while (!line_.empty() && Cursor::is_space(line_.front())) line_.remove_prefix(1);
  }

  // What stands before "="; empty where there is none.
  std::string take_key() {
    const std::size_t equals = line_.find('=');
    if (equals == std::string_view::npos) return {};
    std::string key(line_.substr(0, equals));
    while (!key.empty() && Cursor::is_space(key.back())) key.pop_back();
    for (char& c : key) c = static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
    line_.remove_prefix(equals + 1);
    return key;
  }

  std::string_view word() {
    skip_space();
    std::size_t length = 0;
    while (length < line_.size() && !Cursor::is_space(line_[length])) ++length;
    const std::string_view found = line_.substr(0, length);
    line_.remove_prefix(length);
    return found;
  }
  template <class Number>
  Number number() {
    const char* const place = line_.data();
    const std::string_view text = word();
    Number value{};
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    const bool fits =
        error == std::errc() || (std::is_floating_point_v<Number> && error == std::errc::result_out_of_range);
    if (text.empty() || !fits || end != text.data() + text.size()) file_.fail_at_line("a number is expected", place);
    return value;
  }
  void need_line(const char* what) {
    if (!next_line()) file_.fail_at_line(std::string("the file ends among the ") + what, cursor_.at());
  }

  void read_points(std::uint64_t count) {
    constexpr std::size_t kLeastBytes = 4;
    cursor_.expect(count, kLeastBytes);
    if (!mesh_.points.empty()) file_.fail_at_line("a second list of points", line_.data());
    mesh_.points.reserve(count);
    for (std::uint64_t i = 0; i < count; ++i) {
      need_line("points");
      Vec3 x;
      for (int axis = 0; axis < dim_; ++axis) x[axis] = number<double>();
      mesh_.points.push_back(x);
    }
  }

  void read_elements(std::uint64_t count, std::optional<std::uint32_t> marker) {
    constexpr std::size_t kLeastBytes = 4;
    cursor_.expect(count, kLeastBytes);
    for (std::uint64_t i = 0; i < count; ++i) {
      need_line("elements");
      const auto type = number<int>();
      if (type == kVtkVertex) continue;
      const auto* found = std::ranges::find(kVtkTypes, type);
      if (found == kVtkTypes.end()) refuse_elements(file_, "SU2 type " + std::to_string(type));
      const auto block = static_cast<Block>(found - kVtkTypes.begin());
      if (dimension_of(block) != (marker ? dim_ - 1 : dim_))
        file_.fail_at_line(marker ? "an element of a marker that is no side of a cell" : "a cell of another dimension",
                           line_.data());
      visit_block(mesh_, block, [&](auto& elements, auto& entities) {
        auto& element = elements.emplace_back();
        for (std::uint32_t& v : element) v = stored_index(number<std::uint64_t>());
        entities.push_back(marker.value_or(kNone));
      });
    }
  }

  GroupTags& groups() { return dim_ == 2 ? edges_ : faces_; }

  Mesh finish() {
    check_read_mesh(file_, mesh_);
    const std::vector<std::uint32_t> entity_of = groups().assign(mesh_.entities);
    const auto replace = [&](std::vector<std::uint32_t>& entities) {
      for (std::uint32_t& entity : entities)
        if (entity != kNone) entity = entity_of[entity];
    };
    replace(mesh_.edge_to_entity);
    replace(mesh_.tri_to_entity);
    replace(mesh_.quad_to_entity);
    classify_points(mesh_, {});
    return std::move(mesh_);
  }

  const InputFile& file_;
  Cursor cursor_;
  std::string_view line_;  // what is left of it
  int dim_ = 3;
  Mesh mesh_;
  GroupTags edges_{1}, faces_{2};
  std::optional<std::uint32_t> marker_;
};

}  // namespace

Mesh read_su2(const InputFile& file) { return Su2Reader(file).read(); }

}  // namespace tetloom::detail
