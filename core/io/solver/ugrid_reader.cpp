// UGRID of AFLR3, FUN3D and others, as text or stream. What may stand behind the cells is passed over.
#include "core/io/solver/ugrid_detail.hpp"

namespace tetloom::detail {
namespace {

constexpr std::size_t kItemsBetweenLooks = std::size_t{1} << 16;

class UgridReader {
 public:
  UgridReader(const InputFile& file, UgridForm form) : file_(file), form_(form), cursor_(file, file.bytes()) {}

  Mesh read() {
    if (form_ == UgridForm::Text) require_text();
    const std::uint64_t points = read_count();
    std::array<std::uint64_t, kUgridBlocks.size()> counts;
    for (std::uint64_t& count : counts) count = read_count();
    read_points(points);
    for (std::size_t i = 0; i < counts.size(); ++i) {
      if (kUgridBlocks[i] == Block::Tet) read_tags();
      visit_block(mesh_, kUgridBlocks[i],
                  [&](auto& elements, auto& entities) { read_elements(counts[i], elements, entities); });
    }
    check_read_mesh(file_, mesh_);
    classify_points(mesh_, {});
    return std::move(mesh_);
  }

 private:
  void require_text() const {
    for (const char c : file_.bytes().substr(0, 16))
      if (!Cursor::is_space(c) && (c < ' ' || c > '~'))
        file_.fail(ErrorCode::InputUnsuitable,
                   "the file is no text; binary UGRID files are read as .lb8.ugrid and .b8.ugrid");
  }

  std::int64_t integer() {
    if (form_ == UgridForm::Text) return cursor_.parse<std::int64_t>();
    return cursor_.read<std::int32_t>(form_ == UgridForm::BigEndian);
  }
  double real() {
    if (form_ == UgridForm::Text) return cursor_.parse<double>();
    return cursor_.read<double>(form_ == UgridForm::BigEndian);
  }

  std::uint64_t read_count() {
    const char* const place = cursor_.at();
    const std::int64_t count = integer();
    if (count < 0) file_.fail("a negative count", place);
    return static_cast<std::uint64_t>(count);
  }

  // Throws unless rows of so many numbers can follow; of a text, the last number needs no character behind it.
  void expect(std::uint64_t rows, std::size_t numbers, std::size_t bytes_each) const {
    cursor_.expect(rows, form_ == UgridForm::Text ? 2 * numbers - 1 : numbers * bytes_each);
  }
  void look(std::uint64_t item) const {
    if (item % kItemsBetweenLooks == 0) file_.check_cancelled();
  }

  void read_points(std::uint64_t count) {
    expect(count, 3, sizeof(double));
    if (count >= kNone) file_.fail(ErrorCode::InputUnsuitable, "the file has too many points");
    mesh_.points.resize(count);
    for (std::uint64_t i = 0; i < count; ++i) {
      look(i);
      for (int axis = 0; axis < 3; ++axis) mesh_.points[i][axis] = real();
    }
    mesh_.point_to_entity.resize(count);
  }

  template <class Element>
  void read_elements(std::uint64_t count, std::vector<Element>& elements, std::vector<std::uint32_t>& entities) {
    expect(count, std::tuple_size_v<Element>, sizeof(std::int32_t));
    elements.resize(count);
    entities.assign(count, kNone);
    for (std::uint64_t e = 0; e < count; ++e) {
      look(e);
      Element verts;
      for (std::uint32_t& v : verts) v = stored_index(static_cast<std::uint64_t>(integer()) - 1);
      elements[e] = out_of_ugrid_order(verts);
    }
  }

  void read_tags() {
    for (auto& verts : mesh_.tri_to_vert) verts = turned_over(verts);
    for (auto& verts : mesh_.quad_to_vert) verts = turned_over(verts);
    for (std::vector<std::uint32_t>* entities : {&mesh_.tri_to_entity, &mesh_.quad_to_entity})
      for (std::size_t e = 0; e < entities->size(); ++e) {
        look(e);
        (*entities)[e] = index_of_tag(integer());
      }
  }

  const InputFile& file_;
  UgridForm form_;
  Cursor cursor_;
  Mesh mesh_;
};

}  // namespace

Mesh read_ugrid_text(const InputFile& file) { return UgridReader(file, UgridForm::Text).read(); }

Mesh read_lb8_ugrid(const InputFile& file) { return UgridReader(file, UgridForm::LittleEndian).read(); }

Mesh read_b8_ugrid(const InputFile& file) { return UgridReader(file, UgridForm::BigEndian).read(); }

}  // namespace tetloom::detail
