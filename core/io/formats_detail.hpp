#pragma once
// Private to core/io: one reader and one writer per format, and what they share.
#include <algorithm>
#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/io/atomic_file.hpp"
#include "core/io/input_detail.hpp"
#include "core/io/mesh_parts.hpp"
#include "core/io/mesh_piece.hpp"
#include "core/mesh/mesh_access.hpp"
#include "tetloom/mesh_data.hpp"

namespace tetloom::detail {

// Pre of all writers: require_consistent(mesh).
void write_vtu(const Mesh& mesh, AtomicFile& file, const BlockLoop& loop);
void write_vtu_piece(const Mesh& mesh, std::span<const std::uint64_t> global_ids, AtomicFile& file,
                     const BlockLoop& loop);
void write_msh(const Mesh& mesh, AtomicFile& file, const BlockLoop& loop);
void write_partitioned_msh(const Mesh& mesh, const MeshParts& parts, AtomicFile& file, const BlockLoop& loop);
void write_medit_text(const Mesh& mesh, AtomicFile& file, const BlockLoop& loop);
void write_medit_binary(const Mesh& mesh, AtomicFile& file, const BlockLoop& loop);
void write_msh2_text(const Mesh& mesh, AtomicFile& file, const BlockLoop& loop);
void write_msh2_binary(const Mesh& mesh, AtomicFile& file, const BlockLoop& loop);
void write_bdf(const Mesh& mesh, AtomicFile& file, const BlockLoop& loop);
void write_inp(const Mesh& mesh, AtomicFile& file, const BlockLoop& loop);
void write_su2(const Mesh& mesh, AtomicFile& file, const BlockLoop& loop);
void write_ugrid_text(const Mesh& mesh, AtomicFile& file, const BlockLoop& loop);
void write_lb8_ugrid(const Mesh& mesh, AtomicFile& file, const BlockLoop& loop);
void write_b8_ugrid(const Mesh& mesh, AtomicFile& file, const BlockLoop& loop);
void write_med(const Mesh& mesh, AtomicFile& file, const BlockLoop& loop);
void write_vtkhdf(const Mesh& mesh, AtomicFile& file, const BlockLoop& loop);
void write_cgns(const Mesh& mesh, AtomicFile& file, const BlockLoop& loop);
void write_exodus(const Mesh& mesh, AtomicFile& file, const BlockLoop& loop);
void write_stl(const Mesh& mesh, AtomicFile& file, const BlockLoop& loop);

/// A comment in MSH files of our own, whose volumes have correctly oriented boundaries; those of others often have not.
inline constexpr std::string_view kMshSignature = "tetloom: signed boundaries of volumes point outwards";

// The readers leave checking indices and array lengths to finish_mesh.
Mesh read_vtu(const InputFile& file);
MeshPiece read_vtu_piece(const InputFile& file);
Mesh read_msh(const InputFile& file);
Mesh read_partitioned_msh(const InputFile& file, MeshParts& parts);
Mesh read_medit_text(const InputFile& file);
Mesh read_medit_binary(const InputFile& file);
Mesh read_med(const InputFile& file);
Mesh read_cgns(const InputFile& file);
Mesh read_stl(const InputFile& file);
Mesh read_inp(const InputFile& file);
Mesh read_su2(const InputFile& file);
Mesh read_ugrid_text(const InputFile& file);
Mesh read_lb8_ugrid(const InputFile& file);
Mesh read_b8_ugrid(const InputFile& file);

/// The index that a tag in a file stands for: none for 0 and for what no index can hold.
inline std::uint32_t index_of_tag(std::int64_t tag) {
  return tag >= 1 && tag <= 0xffffffff ? static_cast<std::uint32_t>(tag - 1) : 0xffffffffu;
}
/// The inverse: 0 for none.
inline std::uint32_t tag_of_index(std::uint32_t index) { return index + 1; }

/// A point index in a file as it is stored in a Mesh: what does not fit becomes an index that is out of any range.
inline std::uint32_t stored_index(std::uint64_t index) {
  return index < 0xffffffffu ? static_cast<std::uint32_t>(index) : 0xffffffffu;
}

/// The kinds of elements that a Mesh holds, in the order in which files have them.
enum class Block : std::uint8_t { Edge, Triangle, Quad, Tet, Pyramid, Prism, Hex };
inline constexpr std::size_t kBlocks = 7;

constexpr int dimension_of(Block block) { return block == Block::Edge ? 1 : block <= Block::Quad ? 2 : 3; }
/// Pre: dimension_of(block) == 3.
constexpr std::size_t cell_kind_of(Block block) { return static_cast<std::size_t>(block) - 3; }

/// Calls visit(block, x_to_vert, x_to_entity) for all blocks. `AnyMesh` is Mesh or const Mesh.
template <class AnyMesh, class Visit>
void for_each_block(AnyMesh& mesh, const Visit& visit) {
  visit(Block::Edge, mesh.edge_to_vert, mesh.edge_to_entity);
  visit(Block::Triangle, mesh.tri_to_vert, mesh.tri_to_entity);
  visit(Block::Quad, mesh.quad_to_vert, mesh.quad_to_entity);
  for_each_cell_kind(mesh, [&](CellKind kind, auto& cells, auto& regions) {
    visit(static_cast<Block>(static_cast<std::size_t>(kind) + 3), cells, regions);
  });
}

/// Calls visit(x_to_vert, x_to_entity) for one of them.
template <class AnyMesh, class Visit>
void visit_block(AnyMesh& mesh, Block block, const Visit& visit) {
  for_each_block(mesh, [&](Block each, auto& elements, auto& entities) {
    if (each == block) visit(elements, entities);
  });
}

/// The largest value(i) for i < count; 0 of none.
template <class ValueOf>
std::uint64_t largest_of(std::size_t count, const BlockLoop& loop, const ValueOf& value) {
  const auto find = [&](std::size_t begin, std::size_t end, std::uint64_t& of_block) {
    std::uint64_t found = 0;
    for (std::size_t i = begin; i < end; ++i) found = std::max<std::uint64_t>(found, value(i));
    of_block = found;
  };
  const auto of_blocks = map_blocks(loop, count, std::size_t{1} << 16, std::uint64_t{0}, find);
  return of_blocks.empty() ? 0 : *std::max_element(of_blocks.begin(), of_blocks.end());
}

/// The tag of the entity of a point; 0 where it is unknown.
inline std::uint32_t point_tag(const Mesh& mesh, std::size_t i) {
  const ModelEntity entity = entity_of_point(mesh, i);
  return entity.valid() ? entity.tag() : 0;
}

/// The largest tag of an entity of an element, or of a point.
std::uint64_t largest_tag(const Mesh& mesh, const BlockLoop& loop);

/// The field of that name; null where there is none.
inline MeshField* find_field(std::vector<MeshField>& fields, std::string_view name) {
  for (MeshField& field : fields)
    if (field.name == name) return &field;
  return nullptr;
}

/// Gmsh's types of elements, by Block, and that of points.
inline constexpr std::array<std::int32_t, kBlocks> kMshTypes{1, 2, 3, 4, 7, 6, 5};
inline constexpr std::array<std::int32_t, kBlocks> kMshTypes2{8, 9, 16, 11, 19, 18, 17};  ///< of second order
inline constexpr std::int32_t kMshPoint = 15;

/// Model vertices that a file names.
struct Corner {
  std::uint32_t point = 0;
  std::uint32_t index = 0;  ///< of the model vertex
};

/// Gives every point the entity of the lowest-dimensional elements that use it, where those agree, and model vertices
/// to `corners`. Replaces all of `point_to_entity`. Pre: indices in range.
void classify_points(Mesh& mesh, std::span<const Corner> corners);

/// Throws Error(InputUnreadable) where an index is out of range, Error(InputUnsuitable) where there are no elements.
void check_read_mesh(const InputFile& file, const Mesh& mesh);

/// Throws Error(InputUnsuitable) for elements that a Mesh cannot hold.
[[noreturn]] void refuse_elements(const InputFile& file, const std::string& kind);

/// Room for `count` more items: exactly what a file with one block of them needs, while adding any number of blocks
/// takes time and memory in proportion to the items.
template <class Item>
void reserve_more(std::vector<Item>& items, std::size_t count) {
  const std::size_t needed = items.size() + count;
  if (needed > items.capacity()) items.reserve(items.empty() ? needed : std::max(needed, 2 * items.capacity()));
}

/// Puts `elements` and `ids` in the order of `ids` where those are a permutation of consecutive numbers; else leaves
/// the order of the file.
template <class Element>
void restore_order(std::vector<Element>& elements, std::vector<std::uint32_t>& entities,
                   std::vector<std::uint64_t>& ids) {
  if (std::is_sorted(ids.begin(), ids.end()) || ids.empty()) return;
  const auto [low, high] = std::minmax_element(ids.begin(), ids.end());
  const std::uint64_t first = *low;
  if (*high - first != ids.size() - 1) return;
  std::vector<bool> seen(ids.size(), false);
  for (const std::uint64_t id : ids) {
    if (seen[id - first]) return;
    seen[id - first] = true;
  }
  std::vector<Element> ordered(elements.size());
  std::vector<std::uint32_t> ordered_entities(entities.size());
  for (std::size_t i = 0; i < ids.size(); ++i) {
    ordered[ids[i] - first] = elements[i];
    ordered_entities[ids[i] - first] = entities[i];
  }
  elements.swap(ordered);
  entities.swap(ordered_entities);
  for (std::size_t i = 0; i < ids.size(); ++i) ids[i] = first + i;
}

}  // namespace tetloom::detail
