#pragma once
// The mesh of one part: an ordinary serial mesh with 32-bit local ids, as compact as the field keeps it.
#include <array>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "tetloom/ids.hpp"
#include "tetloom/mesh_data.hpp"
#include "tetloom/model.hpp"
#include "tetloom/storage.hpp"
#include "tetloom/vec.hpp"

namespace tetloom {

/// A model entity in 32 bits: the dimension in the upper two, the index in the others.
class PackedEntity {
 public:
  static constexpr std::uint32_t kMaxIndex = (std::uint32_t{1} << 30) - 2;

  constexpr PackedEntity() = default;
  /// Pre: entity.index <= kMaxIndex, or the entity is invalid.
  constexpr explicit PackedEntity(ModelEntity entity)
      : bits_(entity.valid() ? std::uint32_t{entity.dim} << 30 | entity.index : 0xffffffffu) {}
  constexpr ModelEntity unpack() const {
    return bits_ == 0xffffffffu ? ModelEntity{} : ModelEntity(static_cast<int>(bits_ >> 30), bits_ & 0x3fffffffu);
  }
  friend constexpr auto operator<=>(PackedEntity, PackedEntity) = default;

 private:
  std::uint32_t bits_ = 0xffffffffu;
};

/// A place in a cell in 32 bits: one of its faces, or one of its vertices; or nothing. For tets it is tet · 4 + place
/// below 2³¹; for the other kinds bit 31 is set, the kind stands in bits 30–29, and the rest is cell · 8 + place. So a
/// part holds up to 2²⁹ tets and 2²⁶ cells of each other kind (a departure from 2³⁰ tets, in favour of one code for
/// all).
class CellPlace {
 public:
  static constexpr std::uint32_t kMaxTets = std::uint32_t{1} << 29;
  static constexpr std::uint32_t kMaxOthers = std::uint32_t{1} << 26;

  constexpr CellPlace() = default;
  constexpr CellPlace(CellKind kind, std::uint32_t cell, std::uint32_t place)
      : bits_(kind == CellKind::Tet ? cell * 4 + place
                                    : 0x80000000u | (static_cast<std::uint32_t>(kind) - 1) << 29 | (cell * 8 + place)) {
  }
  constexpr bool valid() const { return bits_ != 0xffffffffu; }
  constexpr CellKind kind() const {
    return bits_ < 0x80000000u ? CellKind::Tet : static_cast<CellKind>((bits_ >> 29 & 3) + 1);
  }
  constexpr std::uint32_t cell() const { return bits_ < 0x80000000u ? bits_ / 4 : (bits_ & 0x1fffffffu) / 8; }
  constexpr std::uint32_t place() const { return bits_ < 0x80000000u ? bits_ % 4 : bits_ % 8; }
  friend constexpr auto operator<=>(CellPlace, CellPlace) = default;

 private:
  std::uint32_t bits_ = 0xffffffffu;
};

/// All cells of one kind. Vertices in the order of tetloom/mesh_data.hpp.
struct CellBlock {
  GrowingArray<std::uint32_t> to_vert;    ///< vertices per cell · cell
  GrowingArray<CellPlace> to_neighbor;    ///< faces per cell · cell: the same face as a face of the cell behind it;
                                          ///< invalid where no cell of this part is
  GrowingArray<std::uint32_t> to_region;  ///< index of the model region, or kNone
  std::size_t size() const { return to_region.size(); }
};

/// Pieces of model faces (3 or 4 vertices each) or of model edges (2).
struct BoundaryBlock {
  GrowingArray<std::uint32_t> to_vert;
  GrowingArray<std::uint32_t> to_entity;  ///< index of the model face or edge, or kNone
  std::size_t size() const { return to_entity.size(); }
};

/// Which boundary elements a BoundaryBlock holds; the value is its index in PartMesh::boundary.
enum class BoundaryKind : std::uint8_t { Edge, Triangle, Quad };
constexpr std::array<std::uint32_t, 3> kBoundaryVertexCount{2, 3, 4};

/// A named field on vertices: `components` values per vertex.
struct VertexField {
  std::string name;
  int components = 1;
  GrowingArray<double> values;
};

/// A named field on cells: per kind, `components` values per cell.
struct CellField {
  std::string name;
  int components = 1;
  std::array<GrowingArray<double>, kCellKinds> values;
};

/// One corner of a group of cells at a vertex, beside the group that the vertex itself names.
struct FurtherPlace {
  std::uint32_t vert = 0;
  CellPlace place;
};

/// What a part knows of a model entity that its mesh is classified on.
struct PartEntity {
  ModelEntity entity;
  bool has_attributes = false;  ///< false: the mesh knows nothing of it but, for a face, its sides
  EntityAttributes attributes;
  FaceSides sides;
};

/// Struct of arrays. 36 bytes per tet and 40 per vertex, beside user fields and the boundary.
///
/// `vert_to_place` names one corner at the vertex; where the cells around a vertex are not connected through faces
/// inside the part, as happens on part boundaries, `further_places` names one corner of each further group, sorted by
/// vertex. Boundary elements are copied to every part that has a cell with them; those without any cell are not kept.
struct PartMesh {
  GrowingArray<Vec3> points;
  GrowingArray<PackedEntity> vert_to_entity;
  GrowingArray<std::uint64_t> vert_to_global;  ///< the same on all copies; distinct within a part
  GrowingArray<CellPlace> vert_to_place;
  GrowingArray<FurtherPlace> further_places;

  std::array<CellBlock, kCellKinds> cells;
  std::array<BoundaryBlock, 3> boundary;
  std::vector<VertexField> vertex_fields;
  std::vector<CellField> cell_fields;
  std::vector<PartEntity> entities;  ///< ascending

  CellBlock& block(CellKind kind) { return cells[static_cast<std::size_t>(kind)]; }
  const CellBlock& block(CellKind kind) const { return cells[static_cast<std::size_t>(kind)]; }
  BoundaryBlock& block(BoundaryKind kind) { return boundary[static_cast<std::size_t>(kind)]; }
  const BoundaryBlock& block(BoundaryKind kind) const { return boundary[static_cast<std::size_t>(kind)]; }
  std::size_t cell_count() const {
    std::size_t count = 0;
    for (const CellBlock& cell_block : cells) count += cell_block.size();
    return count;
  }
  std::size_t vertex_count() const { return points.size(); }
};

/// Bytes of all arrays of `part`, with the room that they have reserved.
std::size_t memory_of(const PartMesh& part);

}  // namespace tetloom
