// MEDIT meshes: text, and binary as in libMeshb, versions 1 to 4, either byte order.
#include <algorithm>
#include <array>
#include <optional>
#include <utility>

#include "core/io/formats_detail.hpp"
#include "core/io/medit_detail.hpp"
#include "core/io/slice_filter_detail.hpp"

namespace tetloom::detail {
namespace {

/// What both forms of the format hold.
struct MeditContent {
  Mesh mesh;
  std::vector<std::uint32_t> point_refs;  // indices, none for 0
  std::vector<std::uint32_t> corner_points;
  SliceFilter* filter = nullptr;  // null: all is read

  bool is_first_pass() const { return filter != nullptr && filter->is_first_pass(); }
  bool wants(Block block, std::uint64_t count) const {
    if (filter == nullptr) return true;
    filter->expect(block, count);
    // Tets are counted before their first one is read.
    if (is_first_pass() && block == Block::Tet && filter->counts().tets != count) filter->set_unfit();
    return filter->wants(block);
  }
  bool keeps_point(std::uint64_t point) const { return filter == nullptr || filter->keeps_point(point); }

  /// Whether the points are read in this pass. A second list of them takes the place of the first.
  bool begin_points(std::uint64_t count) {
    mesh.points.clear(), point_refs.clear();
    if (is_first_pass()) filter->set_points(count);
    if (filter == nullptr) mesh.points.reserve(count), point_refs.reserve(count);
    return !is_first_pass();
  }
  void add_point(std::uint64_t number, const Vec3& point, std::int64_t tag) {
    if (!keeps_point(number)) return;
    mesh.points.push_back(point);
    point_refs.push_back(index_of_tag(tag));
  }

  template <class Element>
  void reserve(std::uint64_t count, std::vector<Element>& elements, std::vector<std::uint32_t>& entities) const {
    if (filter != nullptr) return;
    reserve_more(elements, count);
    reserve_more(entities, count);
  }
  template <class Element>
  void add(const Element& element, std::int64_t tag, std::uint64_t number, std::vector<Element>& elements,
           std::vector<std::uint32_t>& entities) const {
    if (filter != nullptr && !(is_first_pass() ? filter->keeps_tet(number) : filter->keeps(element))) return;
    elements.push_back(element);
    entities.push_back(index_of_tag(tag));
  }

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

  std::optional<FileSlice> finish_slice() {
    std::vector<Corner> corners;
    for (const std::uint32_t point : corner_points)
      if (keeps_point(point)) corners.push_back({point, point_refs[filter->local_of(point)]});
    return filter->finish(std::move(mesh), corners, false);
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
  MeditText(const InputFile& file, MeditContent& content) : file_(file), cursor_(file), content_(content) {}

  void read() {
    for (;;) {
      const std::string_view keyword = cursor_.next_keyword();
      if (keyword == "End") return;
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
      visit_block(content_.mesh, *block,
                  [&](auto& elements, auto& entities) { read_elements(*block, elements, entities); });
    }
  }

  void read_vertices() {
    const auto count = cursor_.read_count(static_cast<std::size_t>(dimension_ + 1) * 2);
    if (!content_.begin_points(count)) return;
    for (std::uint64_t i = 0; i < count; ++i) {
      if (i % kRecordsBetweenLooks == 0) file_.check_cancelled(), file_.let_go();
      Vec3 point;
      for (int axis = 0; axis < dimension_; ++axis) point[axis] = cursor_.parse<double>();
      content_.add_point(i, point, cursor_.parse<std::int64_t>());
    }
  }

  template <class Element>
  void read_elements(Block block, std::vector<Element>& elements, std::vector<std::uint32_t>& entities) {
    Element element;
    const auto count = cursor_.read_count(2 * (element.size() + 1));
    if (!content_.wants(block, count)) return;
    content_.reserve(count, elements, entities);
    for (std::uint64_t i = 0; i < count; ++i) {
      if (i % kRecordsBetweenLooks == 0) file_.check_cancelled(), file_.let_go();
      for (std::uint32_t& v : element) v = stored_index(cursor_.parse<std::uint64_t>() - 1);
      content_.add(element, cursor_.parse<std::int64_t>(), i, elements, entities);
    }
  }

  const InputFile& file_;
  MeditWords cursor_;
  int dimension_ = 3;
  MeditContent& content_;
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
  MeditBinary(const InputFile& file, MeditContent& content) : file_(file), sections_(file), content_(content) {}

  void read() {
    for (;;) {
      const std::int32_t code = sections_.next_section();
      if (code == kMeditEnd) return;
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
      visit_block(content_.mesh, *block,
                  [&](auto& elements, auto& entities) { read_elements(*block, elements, entities); });
    }
  }

  void read_vertices() {
    const std::uint64_t count = read_count(1, static_cast<std::size_t>(dimension_));
    if (!content_.begin_points(count)) return;
    for (std::uint64_t i = 0; i < count; ++i) {
      if (i % kRecordsBetweenLooks == 0) file_.check_cancelled(), file_.let_go();
      Vec3 point;
      for (int axis = 0; axis < dimension_; ++axis) point[axis] = sections_.read_real();
      content_.add_point(i, point, sections_.read_integer());
    }
  }

  template <class Element>
  void read_elements(Block block, std::vector<Element>& elements, std::vector<std::uint32_t>& entities) {
    Element element;
    const std::uint64_t count = read_count(element.size() + 1, 0);
    if (!content_.wants(block, count)) return;
    content_.reserve(count, elements, entities);
    for (std::uint64_t i = 0; i < count; ++i) {
      if (i % kRecordsBetweenLooks == 0) file_.check_cancelled(), file_.let_go();
      for (std::uint32_t& v : element) v = read_index();
      content_.add(element, sections_.read_integer(), i, elements, entities);
    }
  }

  const InputFile& file_;
  MeditSections sections_;
  int dimension_ = 3;
  MeditContent& content_;
};

template <class Reader>
Mesh read_whole(const InputFile& file) {
  MeditContent content;
  Reader(file, content).read();
  return content.finish(file);
}

template <class Reader>
std::optional<FileSlice> read_slice_of(const InputFile& file, SliceFilter& filter) {
  MeditContent content;
  content.filter = &filter;
  Reader(file, content).read();
  filter.begin_second_pass(content.mesh);
  if (!filter.is_fit()) return {};
  content.corner_points.clear();
  Reader(file, content).read();
  return content.finish_slice();
}

}  // namespace

Mesh read_medit_text(const InputFile& file) { return read_whole<MeditText>(file); }

Mesh read_medit_binary(const InputFile& file) { return read_whole<MeditBinary>(file); }

std::optional<FileSlice> read_medit_text_slice(const InputFile& file, SliceFilter& filter) {
  return read_slice_of<MeditText>(file, filter);
}

std::optional<FileSlice> read_medit_binary_slice(const InputFile& file, SliceFilter& filter) {
  return read_slice_of<MeditBinary>(file, filter);
}

}  // namespace tetloom::detail
