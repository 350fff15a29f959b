// MEDIT meshes: text, and binary as in libMeshb, versions 1 to 4, either byte order.
#include <algorithm>
#include <array>
#include <cctype>
#include <optional>
#include <utility>

#include "core/io/formats_detail.hpp"

namespace tetloom::detail {
namespace {

constexpr std::size_t kRecordsBetweenLooks = std::size_t{1} << 20;

/// What both forms of the format hold.
struct MeditContent {
  Mesh mesh;
  std::vector<std::uint32_t> point_refs;  // indices, none for 0
  std::vector<std::uint32_t> corner_points;

  Mesh finish(const InputFile& file) {
    check_read_mesh(file, mesh);
    std::vector<Corner> corners;
    for (const std::uint32_t point : corner_points) {
      if (point >= mesh.points.size())
        file.fail(ErrorCode::InputUnreadable, "a corner refers to a point that is not there");
      corners.push_back({point, point_refs[point]});
    }
    classify_points(mesh, corners);
    return std::move(mesh);
  }
};

std::optional<Block> block_of(std::string_view keyword) {
  static constexpr std::array<std::pair<std::string_view, Block>, 8> known{{{"Edges", Block::Edge},
                                                                            {"Triangles", Block::Triangle},
                                                                            {"Quadrilaterals", Block::Quad},
                                                                            {"Tetrahedra", Block::Tet},
                                                                            {"Pyramids", Block::Pyramid},
                                                                            {"Prisms", Block::Prism},
                                                                            {"Hexahedra", Block::Hex},
                                                                            {"Hexaedra", Block::Hex}}};
  for (const auto& [name, block] : known)
    if (name == keyword) return block;
  return {};
}

/// Elements of higher order are named like EdgesP2, TetrahedraP3 or QuadrilateralsQ2.
bool is_unsupported_element(std::string_view keyword) {
  if (keyword.size() < 3) return false;
  const std::string_view ending = keyword.substr(keyword.size() - 2);
  return (ending.front() == 'P' || ending.front() == 'Q') && block_of(keyword.substr(0, keyword.size() - 2));
}

class MeditText {
 public:
  explicit MeditText(const InputFile& file) : file_(file), cursor_(file, file.bytes()) {}

  Mesh read() {
    for (;;) {
      const std::string_view keyword = next_keyword();
      if (keyword.empty()) file_.fail_at_line("the file ends without the keyword End", cursor_.at());
      if (keyword == "End") return content_.finish(file_);
      read_section(keyword);
    }
  }

 private:
  /// Skips everything up to a word: the numbers of keywords that are of no interest here, and comments.
  std::string_view next_keyword() {
    for (;;) {
      const std::string_view word = cursor_.token();
      if (word.empty()) return word;
      if (word.front() == '#') {
        if (cursor_.at() > word.data()) cursor_.jump(word.data());
        cursor_.line();
        continue;
      }
      const bool is_number = word.starts_with("nan") || word.starts_with("inf");
      if (std::isalpha(static_cast<unsigned char>(word.front())) != 0 && !is_number) return word;
    }
  }

  void read_section(std::string_view keyword) {
    if (keyword == "MeshVersionFormatted") {
      static_cast<void>(cursor_.parse<int>());
    } else if (keyword == "Dimension") {
      dimension_ = cursor_.parse<int>();
      if (dimension_ != 2 && dimension_ != 3) file_.fail_at_line("the dimension must be 2 or 3", cursor_.at());
    } else if (keyword == "Vertices") {
      read_vertices();
    } else if (keyword == "Corners") {
      const auto count = read_count(2);
      for (std::uint64_t i = 0; i < count; ++i)
        content_.corner_points.push_back(stored_index(cursor_.parse<std::uint64_t>() - 1));
    } else if (is_unsupported_element(keyword)) {
      if (read_count(2) > 0) refuse_elements(file_, std::string(keyword));
    } else if (const std::optional<Block> block = block_of(keyword)) {
      visit_block(content_.mesh, *block, [&](auto& elements, auto& entities) { read_elements(elements, entities); });
    }
  }

  std::uint64_t read_count(std::size_t bytes_each) {
    const auto count = cursor_.parse<std::uint64_t>();
    // The last number may end at the end of the file, without a separator.
    if (count > cursor_.left() / bytes_each + 1)
      file_.fail_at_line("a count of " + std::to_string(count) + " exceeds the file", cursor_.at());
    return count;
  }

  void read_vertices() {
    const auto count = read_count(static_cast<std::size_t>(dimension_ + 1) * 2);
    content_.mesh.points.clear();
    content_.mesh.points.reserve(count);
    content_.point_refs.clear();
    for (std::uint64_t i = 0; i < count; ++i) {
      if (i % kRecordsBetweenLooks == 0) file_.check_cancelled();
      Vec3 point;
      for (int axis = 0; axis < dimension_; ++axis) point[axis] = cursor_.parse<double>();
      content_.mesh.points.push_back(point);
      content_.point_refs.push_back(index_of_tag(cursor_.parse<std::int64_t>()));
    }
  }

  template <class Element>
  void read_elements(std::vector<Element>& elements, std::vector<std::uint32_t>& entities) {
    Element element;
    const auto count = read_count(2 * (element.size() + 1));
    elements.reserve(elements.size() + count);
    entities.reserve(entities.size() + count);
    for (std::uint64_t i = 0; i < count; ++i) {
      if (i % kRecordsBetweenLooks == 0) file_.check_cancelled();
      for (std::uint32_t& v : element) v = stored_index(cursor_.parse<std::uint64_t>() - 1);
      elements.push_back(element);
      entities.push_back(index_of_tag(cursor_.parse<std::int64_t>()));
    }
  }

  const InputFile& file_;
  Cursor cursor_;
  int dimension_ = 3;
  MeditContent content_;
};

/// Keywords of binary files that matter here.
struct MeditCode {
  int code;
  std::string_view keyword;
};
constexpr std::array<MeditCode, 15> kMeditCodes{{{4, "Vertices"},
                                                 {5, "Edges"},
                                                 {6, "Triangles"},
                                                 {7, "Quadrilaterals"},
                                                 {8, "Tetrahedra"},
                                                 {9, "Prisms"},
                                                 {10, "Hexahedra"},
                                                 {13, "Corners"},
                                                 {24, "TrianglesP2"},
                                                 {25, "EdgesP2"},
                                                 {27, "QuadrilateralsQ2"},
                                                 {30, "TetrahedraP2"},
                                                 {33, "HexahedraQ2"},
                                                 {49, "Pyramids"},
                                                 {54, "End"}}};

class MeditBinary {
 public:
  explicit MeditBinary(const InputFile& file) : file_(file), cursor_(file, file.bytes()) {
    const auto code = cursor_.read<std::uint32_t>();
    swap_ = code == 0x01000000;
    if (code != 1 && !swap_) file_.fail(ErrorCode::InputUnreadable, "no binary MEDIT file by its first bytes");
    version_ = cursor_.read<std::int32_t>(swap_);
    if (version_ < 1 || version_ > 4) file_.fail("version " + std::to_string(version_) + " is unknown", cursor_.at());
  }

  Mesh read() {
    for (;;) {
      const auto code = cursor_.read<std::int32_t>(swap_);
      const std::string_view keyword = name_of(code);
      if (keyword == "End") return content_.finish(file_);
      const std::uint64_t next =
          version_ >= 3 ? cursor_.read<std::uint64_t>(swap_) : cursor_.read<std::uint32_t>(swap_);
      const auto here = static_cast<std::uint64_t>(cursor_.at() - file_.bytes().data());
      if (next <= here || next > file_.bytes().size())
        file_.fail("the place of the next keyword is outside of the file", cursor_.at());
      const Cursor after(file_, file_.bytes().substr(next));
      cursor_ = Cursor(file_, file_.bytes().substr(here, next - here));
      if (code == 3)
        read_dimension();
      else
        read_section(keyword);
      cursor_ = after;
    }
  }

 private:
  static std::string_view name_of(int code) {
    for (const MeditCode& known : kMeditCodes)
      if (known.code == code) return known.keyword;
    return {};
  }

  std::int64_t read_integer() {
    return version_ == 4 ? cursor_.read<std::int64_t>(swap_) : cursor_.read<std::int32_t>(swap_);
  }
  double read_real() { return version_ == 1 ? cursor_.read<float>(swap_) : cursor_.read<double>(swap_); }
  std::uint32_t read_index() { return stored_index(static_cast<std::uint64_t>(read_integer()) - 1); }

  std::uint64_t read_count(std::size_t integers, std::size_t reals) {
    const auto count = static_cast<std::uint64_t>(read_integer());
    cursor_.expect(count, integers * (version_ == 4 ? 8 : 4) + reals * (version_ == 1 ? 4 : 8));
    return count;
  }

  void read_dimension() {
    dimension_ = cursor_.read<std::int32_t>(swap_);
    if (dimension_ != 2 && dimension_ != 3) file_.fail("the dimension must be 2 or 3", cursor_.at());
  }

  void read_section(std::string_view keyword) {
    if (keyword == "Vertices") {
      read_vertices();
    } else if (keyword == "Corners") {
      const std::uint64_t count = read_count(1, 0);
      for (std::uint64_t i = 0; i < count; ++i) content_.corner_points.push_back(read_index());
    } else if (is_unsupported_element(keyword)) {
      if (read_count(1, 0) > 0) refuse_elements(file_, std::string(keyword));
    } else if (const std::optional<Block> block = block_of(keyword)) {
      visit_block(content_.mesh, *block, [&](auto& elements, auto& entities) { read_elements(elements, entities); });
    }
  }

  void read_vertices() {
    const std::uint64_t count = read_count(1, static_cast<std::size_t>(dimension_));
    content_.mesh.points.assign(count, {});
    content_.point_refs.assign(count, 0);
    for (std::uint64_t i = 0; i < count; ++i) {
      if (i % kRecordsBetweenLooks == 0) file_.check_cancelled();
      for (int axis = 0; axis < dimension_; ++axis) content_.mesh.points[i][axis] = read_real();
      content_.point_refs[i] = index_of_tag(read_integer());
    }
  }

  template <class Element>
  void read_elements(std::vector<Element>& elements, std::vector<std::uint32_t>& entities) {
    Element element;
    const std::uint64_t count = read_count(element.size() + 1, 0);
    elements.reserve(elements.size() + count);
    entities.reserve(entities.size() + count);
    for (std::uint64_t i = 0; i < count; ++i) {
      if (i % kRecordsBetweenLooks == 0) file_.check_cancelled();
      for (std::uint32_t& v : element) v = read_index();
      elements.push_back(element);
      entities.push_back(index_of_tag(read_integer()));
    }
  }

  const InputFile& file_;
  Cursor cursor_;
  bool swap_ = false;
  int version_ = 0;
  int dimension_ = 3;
  MeditContent content_;
};

}  // namespace

Mesh read_medit_text(const InputFile& file) {
  const std::string_view first = Cursor(file, file.bytes()).token();
  if (first != "MeshVersionFormatted" && !first.starts_with('#'))
    file.fail(ErrorCode::InputUnreadable, "no MEDIT file: it does not start with MeshVersionFormatted");
  return MeditText(file).read();
}

Mesh read_medit_binary(const InputFile& file) { return MeditBinary(file).read(); }

}  // namespace tetloom::detail
