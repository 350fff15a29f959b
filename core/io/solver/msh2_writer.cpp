// MSH 2.2 of Gmsh, as text or binary, which more programs read than read 4.1: a physical group of its name for every
// edge, face and region. Triangles and quadrilaterals point out of the one region at their face. Fields are left out.
#include "core/io/formats_detail.hpp"
#include "core/io/msh_detail.hpp"
#include "core/io/solver/groups.hpp"
#include "core/io/solver/number_text.hpp"

namespace tetloom::detail {
namespace {

void write_names(const Groups& groups, AtomicFile& file) {
  std::size_t count = 0;
  for (std::size_t dim = 1; dim < groups.size(); ++dim) count += groups[dim].size();
  if (count == 0) return;
  file.write("$PhysicalNames\n" + std::to_string(count) + "\n");
  for (std::size_t dim = 1; dim < groups.size(); ++dim)
    for (const Group& group : groups[dim])
      file.write(std::to_string(dim) + " " + std::to_string(group.tag) + " \"" + group.name + "\"\n");
  file.write("$EndPhysicalNames\n");
}

// A point with its number, as a binary file has it.
using PointRecord = std::array<char, sizeof(std::int32_t) + sizeof(Vec3)>;

void write_points(const Mesh& mesh, bool is_text, AtomicFile& file, const BlockLoop& loop) {
  file.write("$Nodes\n" + std::to_string(mesh.points.size()) + "\n");
  if (is_text) {
    const auto print_block = [&](std::size_t begin, std::size_t end, char* out) {
      for (std::size_t v = begin; v < end; ++v) {
        out = print(out, v + 1, ' ');
        for (int axis = 0; axis < 3; ++axis) out = print(out, mesh.points[v][axis], axis < 2 ? ' ' : '\n');
      }
      return out;
    };
    file.write_lines(mesh.points.size(), kIntegerBytes + 3 * kRealBytes, print_block, loop);
  } else {
    const auto record_of = [&](std::size_t v) {
      PointRecord record;
      const auto number = static_cast<std::int32_t>(v + 1);
      std::memcpy(record.data(), &number, sizeof number);
      std::memcpy(record.data() + sizeof number, &mesh.points[v], sizeof(Vec3));
      return record;
    };
    file.put_each(mesh.points.size(), record_of, loop);
    file.write("\n");
  }
  file.write("$EndNodes\n");
}

/// Writes the elements of one block, whose numbers begin at `first`.
template <class Element>
void write_block(const Mesh& mesh, const ElementNodes& nodes, Block block, const std::vector<Element>& elements,
                 const std::vector<std::uint32_t>& entities, std::size_t first, bool is_text, AtomicFile& file,
                 const BlockLoop& loop) {
  const std::int32_t type = (nodes.are_second_order() ? kMshTypes2 : kMshTypes)[static_cast<std::size_t>(block)];
  const auto nodes_of = [&](std::size_t e) {
    return nodes.of(turned_outwards(mesh, dimension_of(block), elements[e], entities[e]), msh_edges_of(block));
  };
  if (!is_text) {
    for (const std::int32_t value : {type, static_cast<std::int32_t>(elements.size()), std::int32_t{2}})
      file.put(value);
    const auto encode = [&](std::size_t begin, std::size_t end, char* out) {
      const auto put = [&out](std::size_t number) {
        const auto value = static_cast<std::int32_t>(number);
        std::memcpy(out, &value, sizeof value);
        out += sizeof value;
      };
      for (std::size_t e = begin; e < end; ++e) {
        put(first + e);
        for (int i = 0; i < 2; ++i) put(tag_of_index(entities[e]));
        for (const std::uint32_t node : nodes_of(e)) put(node + std::size_t{1});
      }
    };
    return file.write_records(elements.size(), (3 + nodes.count(block)) * sizeof(std::int32_t), encode, loop);
  }
  const auto print_block = [&](std::size_t begin, std::size_t end, char* out) {
    for (std::size_t e = begin; e < end; ++e) {
      out = print(out, first + e, ' ');
      out = print(print(out, type, ' '), 2, ' ');
      for (int i = 0; i < 2; ++i) out = print(out, tag_of_index(entities[e]), ' ');
      const NodeList own = nodes_of(e);
      for (std::size_t i = 0; i < own.size(); ++i)
        out = print(out, std::uint64_t{own[i]} + 1, i + 1 < own.size() ? ' ' : '\n');
    }
    return out;
  };
  file.write_lines(elements.size(), (nodes.count(block) + 5) * kIntegerBytes, print_block, loop);
}

void write_msh2(const Mesh& mesh, bool is_text, AtomicFile& file, const BlockLoop& loop) {
  std::size_t count = 0;
  for_each_block(mesh, [&](Block, const auto& elements, const auto&) { count += elements.size(); });
  if (std::max(count, mesh.points.size()) > 0x7fffffff || largest_tag(mesh, loop) > 0x7fffffff)
    throw Error(ErrorCode::InvalidArgument, "the mesh has numbers beyond the 31 bits that MSH 2.2 allows");
  file.write(is_text ? "$MeshFormat\n2.2 0 8\n" : "$MeshFormat\n2.2 1 8\n");
  if (!is_text) file.put(std::int32_t{1}), file.write("\n");
  file.write("$EndMeshFormat\n");
  write_names(make_groups(mesh), file);
  write_points(mesh, is_text, file, loop);
  file.write("$Elements\n" + std::to_string(count) + "\n");
  const ElementNodes nodes(mesh);
  std::size_t first = 1;
  for_each_block(mesh, [&](Block block, const auto& elements, const auto& entities) {
    if (elements.empty()) return;
    write_block(mesh, nodes, block, elements, entities, first, is_text, file, loop);
    first += elements.size();
  });
  file.write(is_text ? "$EndElements\n" : "\n$EndElements\n");
}

}  // namespace

void write_msh2_text(const Mesh& mesh, AtomicFile& file, const BlockLoop& loop) { write_msh2(mesh, true, file, loop); }

void write_msh2_binary(const Mesh& mesh, AtomicFile& file, const BlockLoop& loop) {
  write_msh2(mesh, false, file, loop);
}

}  // namespace tetloom::detail
