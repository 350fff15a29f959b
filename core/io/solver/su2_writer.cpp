// Meshes of SU2: cells, points, and a marker for every face of the model that bounds the cells. Markers point out of
// the domain. Faces between two regions, regions' names, edges and fields are left out.
#include <algorithm>

#include "core/io/formats_detail.hpp"
#include "core/io/solver/groups.hpp"
#include "core/io/solver/number_text.hpp"
#include "core/io/vtu_detail.hpp"

namespace tetloom::detail {
namespace {

bool is_internal(const Mesh& mesh, std::uint32_t face) {
  return face < mesh.face_to_sides.size() && mesh.face_to_sides[face].front.valid() &&
         mesh.face_to_sides[face].back.valid();
}

void drop_internal(const Mesh& mesh, Group& group) {
  const std::size_t triangles = mesh.tri_to_entity.size();
  std::erase_if(group.elements, [&](std::uint32_t e) {
    return is_internal(mesh, e < triangles ? mesh.tri_to_entity[e] : mesh.quad_to_entity[e - triangles]);
  });
}

// In a file, a line: the type, then the vertices.
template <class Element>
char* print_element(char* out, Block block, const Element& verts) {
  out = print(out, int{kVtkTypes[static_cast<std::size_t>(block)]}, ' ');
  for (std::size_t i = 0; i < verts.size(); ++i) out = print(out, verts[i], i + 1 < verts.size() ? ' ' : '\n');
  return out;
}

void write_cells(const Mesh& mesh, int dim, AtomicFile& file, const BlockLoop& loop) {
  for_each_block(mesh, [&](Block block, const auto& elements, const auto&) {
    if (dimension_of(block) != dim || elements.empty()) return;
    const auto print_block = [&](std::size_t begin, std::size_t end, char* out) {
      for (std::size_t e = begin; e < end; ++e) out = print_element(out, block, elements[e]);
      return out;
    };
    file.write_lines(elements.size(), (elements[0].size() + 1) * kIntegerBytes, print_block, loop);
  });
}

void write_marker(const Mesh& mesh, int dim, const Group& group, AtomicFile& file, const BlockLoop& loop) {
  file.write("MARKER_TAG= " + group.name + "\nMARKER_ELEMS= " + std::to_string(group.elements.size()) + "\n");
  std::size_t first = 0;
  for_each_block(mesh, [&](Block block, const auto& elements, const auto& entities) {
    if (dimension_of(block) != dim) return;
    const auto begin = std::ranges::lower_bound(group.elements, first);
    const auto end = std::ranges::lower_bound(group.elements, first + elements.size());
    const auto print_block = [&](std::size_t from, std::size_t to, char* out) {
      for (std::size_t i = from; i < to; ++i) {
        const std::size_t e = begin[static_cast<std::ptrdiff_t>(i)] - first;
        out = print_element(out, block, turned_outwards(mesh, dim, elements[e], entities[e]));
      }
      return out;
    };
    if (begin != end)
      file.write_lines(static_cast<std::size_t>(end - begin), (elements[0].size() + 1) * kIntegerBytes, print_block,
                       loop);
    first += elements.size();
  });
}

}  // namespace

void write_su2(const Mesh& mesh, AtomicFile& file, const BlockLoop& loop) {
  const int dim = cell_count(mesh) > 0 ? 3 : 2;
  file.write("% tetloom\nNDIME= 3\nNELEM= " + std::to_string(dim == 3 ? cell_count(mesh) : surface_count(mesh)) + "\n");
  write_cells(mesh, dim, file, loop);
  file.write("NPOIN= " + std::to_string(mesh.points.size()) + "\n");
  const auto print_points = [&](std::size_t begin, std::size_t end, char* out) {
    for (std::size_t v = begin; v < end; ++v)
      for (int axis = 0; axis < 3; ++axis) out = print(out, mesh.points[v][axis], axis < 2 ? ' ' : '\n');
    return out;
  };
  file.write_lines(mesh.points.size(), 3 * kRealBytes, print_points, loop);
  Groups groups = make_groups(mesh);
  std::vector<Group> markers;
  for (Group& group : groups[static_cast<std::size_t>(dim - 1)]) {
    if (dim == 3) drop_internal(mesh, group);
    if (!group.elements.empty()) markers.push_back(std::move(group));
  }
  file.write("NMARK= " + std::to_string(markers.size()) + "\n");
  for (const Group& group : markers) write_marker(mesh, dim - 1, group, file, loop);
}

}  // namespace tetloom::detail
