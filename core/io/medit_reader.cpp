// MEDIT meshes: text, and binary as in libMeshb, versions 1 to 4, either byte order.
#include <algorithm>
#include <array>
#include <optional>
#include <utility>

#include "core/io/formats_detail.hpp"
#include "core/io/medit_detail.hpp"

namespace tetloom::detail {
namespace {

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
  explicit MeditText(const InputFile& file) : file_(file), cursor_(file) {}

  Mesh read() {
    for (;;) {
      const std::string_view keyword = cursor_.next_keyword();
      if (keyword == "End") return content_.finish(file_);
      read_section(keyword);
    }
  }

 private:
  void read_section(std::string_view keyword) {
    if (keyword == "MeshVersionFormatted") {
      static_cast<void>(cursor_.parse<int>());
    } else if (keyword == "Dimension") {
      dimension_ = cursor_.read_dimension();
    } else if (keyword == "Vertices") {
      read_vertices();
    } else if (keyword == "Corners") {
      const auto count = cursor_.read_count(2);
      for (std::uint64_t i = 0; i < count; ++i)
        content_.corner_points.push_back(stored_index(cursor_.parse<std::uint64_t>() - 1));
    } else if (is_unsupported_element(keyword)) {
      if (cursor_.read_count(2) > 0) refuse_elements(file_, std::string(keyword));
    } else if (const std::optional<Block> block = block_of(keyword)) {
      visit_block(content_.mesh, *block, [&](auto& elements, auto& entities) { read_elements(elements, entities); });
    }
  }

  void read_vertices() {
    const auto count = cursor_.read_count(static_cast<std::size_t>(dimension_ + 1) * 2);
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
    const auto count = cursor_.read_count(2 * (element.size() + 1));
    reserve_more(elements, count);
    reserve_more(entities, count);
    for (std::uint64_t i = 0; i < count; ++i) {
      if (i % kRecordsBetweenLooks == 0) file_.check_cancelled();
      for (std::uint32_t& v : element) v = stored_index(cursor_.parse<std::uint64_t>() - 1);
      elements.push_back(element);
      entities.push_back(index_of_tag(cursor_.parse<std::int64_t>()));
    }
  }

  const InputFile& file_;
  MeditWords cursor_;
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
  explicit MeditBinary(const InputFile& file) : file_(file), sections_(file) {}

  Mesh read() {
    for (;;) {
      const std::int32_t code = sections_.next_section();
      if (code == kMeditEnd) return content_.finish(file_);
      if (code == kMeditDimension)
        dimension_ = sections_.read_dimension();
      else
        read_section(name_of(code));
    }
  }

 private:
  static std::string_view name_of(int code) {
    for (const MeditCode& known : kMeditCodes)
      if (known.code == code) return known.keyword;
    return {};
  }

  std::uint32_t read_index() { return stored_index(static_cast<std::uint64_t>(sections_.read_integer()) - 1); }

  std::uint64_t read_count(std::size_t integers, std::size_t reals) {
    const std::uint64_t count = sections_.read_count();
    sections_.expect(count, integers, reals);
    return count;
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
      for (int axis = 0; axis < dimension_; ++axis) content_.mesh.points[i][axis] = sections_.read_real();
      content_.point_refs[i] = index_of_tag(sections_.read_integer());
    }
  }

  template <class Element>
  void read_elements(std::vector<Element>& elements, std::vector<std::uint32_t>& entities) {
    Element element;
    const std::uint64_t count = read_count(element.size() + 1, 0);
    reserve_more(elements, count);
    reserve_more(entities, count);
    for (std::uint64_t i = 0; i < count; ++i) {
      if (i % kRecordsBetweenLooks == 0) file_.check_cancelled();
      for (std::uint32_t& v : element) v = read_index();
      elements.push_back(element);
      entities.push_back(index_of_tag(sections_.read_integer()));
    }
  }

  const InputFile& file_;
  MeditSections sections_;
  int dimension_ = 3;
  MeditContent content_;
};

}  // namespace

Mesh read_medit_text(const InputFile& file) { return MeditText(file).read(); }

Mesh read_medit_binary(const InputFile& file) { return MeditBinary(file).read(); }

}  // namespace tetloom::detail
