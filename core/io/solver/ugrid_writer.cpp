// UGRID of AFLR3, FUN3D and others: points, boundary triangles and quadrilaterals with the tags of their faces, which
// point into the domain, and cells. Regions, edges and fields are left out; names of faces go to a .mapbc file.
#include "core/io/solver/groups.hpp"
#include "core/io/solver/number_text.hpp"
#include "core/io/solver/ugrid_detail.hpp"

namespace tetloom::detail {
namespace {

class UgridWriter {
 public:
  UgridWriter(const Mesh& mesh, UgridForm form, AtomicFile& file, const BlockLoop& loop)
      : mesh_(mesh), form_(form), file_(file), loop_(loop) {}

  void write() {
    write_counts();
    write_rows(mesh_.points.size(), [&](std::size_t v) {
      const Vec3& x = mesh_.points[v];
      return std::array<double, 3>{x.x, x.y, x.z};
    });
    write_surface(mesh_.tri_to_vert, mesh_.tri_to_entity);
    write_surface(mesh_.quad_to_vert, mesh_.quad_to_entity);
    write_tags(mesh_.tri_to_entity);
    write_tags(mesh_.quad_to_entity);
    for_each_cell_kind(mesh_, [&](CellKind, const auto& cells, const auto&) {
      write_rows(cells.size(), [&](std::size_t c) { return counted_from_one(in_ugrid_order(cells[c])); });
    });
  }

 private:
  void write_counts() {
    std::array<std::uint32_t, kUgridBlocks.size() + 1> counts;
    const auto put = [&](std::size_t place, std::size_t count) {
      if (count > kMostNumber)
        throw Error(ErrorCode::InvalidArgument, "the mesh has more elements or points than UGRID allows");
      counts[place] = static_cast<std::uint32_t>(count);
    };
    put(0, mesh_.points.size());
    for (std::size_t i = 0; i < kUgridBlocks.size(); ++i)
      visit_block(mesh_, kUgridBlocks[i], [&](const auto& elements, const auto&) { put(i + 1, elements.size()); });
    write_rows(1, [&](std::size_t) { return counts; });
  }

  template <class Element>
  void write_surface(const std::vector<Element>& elements, const std::vector<std::uint32_t>& entities) {
    write_rows(elements.size(), [&](std::size_t e) {
      return counted_from_one(turned_over(turned_outwards(mesh_, 2, elements[e], entities[e])));
    });
  }

  void write_tags(const std::vector<std::uint32_t>& entities) {
    write_rows(entities.size(), [&](std::size_t e) { return std::array{tag_of_index(entities[e])}; });
  }

  template <class Element>
  static Element counted_from_one(Element verts) {
    for (std::uint32_t& v : verts) ++v;
    return verts;
  }

  // Rows of an array each: lines of a text, or the numbers one after the other.
  template <class RowOf>
  void write_rows(std::size_t count, const RowOf& row_of) {
    using Row = decltype(row_of(std::size_t{0}));
    using Number = typename Row::value_type;
    constexpr std::size_t length = std::tuple_size_v<Row>;
    if (form_ != UgridForm::Text)
      return file_.put_each(
          count,
          [&](std::size_t i) {
            Row row = row_of(i);
            if (form_ == UgridForm::BigEndian)
              for (Number& number : row) number = byte_swapped(number);
            return row;
          },
          loop_);
    const auto print_block = [&](std::size_t begin, std::size_t end, char* out) {
      for (std::size_t i = begin; i < end; ++i) {
        const Row row = row_of(i);
        for (std::size_t k = 0; k < length; ++k) out = print(out, row[k], k + 1 < length ? ' ' : '\n');
      }
      return out;
    };
    file_.write_lines(count, length * (std::is_floating_point_v<Number> ? kRealBytes : kIntegerBytes), print_block,
                      loop_);
  }

  const Mesh& mesh_;
  UgridForm form_;
  AtomicFile& file_;
  const BlockLoop& loop_;
};

}  // namespace

void write_ugrid_text(const Mesh& mesh, AtomicFile& file, const BlockLoop& loop) {
  UgridWriter(mesh, UgridForm::Text, file, loop).write();
}

void write_lb8_ugrid(const Mesh& mesh, AtomicFile& file, const BlockLoop& loop) {
  UgridWriter(mesh, UgridForm::LittleEndian, file, loop).write();
}

void write_b8_ugrid(const Mesh& mesh, AtomicFile& file, const BlockLoop& loop) {
  UgridWriter(mesh, UgridForm::BigEndian, file, loop).write();
}

}  // namespace tetloom::detail
