#pragma once
// Who is next to whom in a part. Nothing but neighbours across faces and one corner per vertex is stored.
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "tetloom/part_mesh.hpp"

namespace tetloom {

/// A cell by kind and index.
struct CellId {
  CellKind kind = CellKind::Tet;
  std::uint32_t index = 0;
  friend constexpr auto operator<=>(const CellId&, const CellId&) = default;
};

/// Numbers for the cells of all kinds together, from `begin` on: tets first, then pyramids, prisms and hexahedra.
class CellNumbers {
 public:
  explicit CellNumbers(const PartMesh& part, std::uint64_t begin = 0) {
    for (std::size_t kind = 0; kind < kCellKinds; ++kind) {
      begins_[kind] = begin;
      begin += part.cells[kind].size();
    }
  }
  std::uint64_t begin_of(CellKind kind) const { return begins_[static_cast<std::size_t>(kind)]; }
  std::uint64_t number_of(CellId cell) const { return begin_of(cell.kind) + cell.index; }
  std::uint64_t number_of(CellPlace place) const { return begin_of(place.kind()) + place.cell(); }
  CellId cell_of(std::uint64_t number) const {
    std::size_t kind = kCellKinds - 1;
    while (begins_[kind] > number) --kind;
    return {kAllCellKinds[kind], static_cast<std::uint32_t>(number - begins_[kind])};
  }

 private:
  std::array<std::uint64_t, kCellKinds> begins_{};
};

/// The vertices of a face or an edge of a cell as a key that does not depend on the side it is seen from: ascending,
/// the unused places kNone.
using FaceKey = std::array<std::uint32_t, 4>;

inline std::span<const std::uint32_t> vertices_of(const PartMesh& part, CellId cell) {
  const std::size_t n = shape_of(cell.kind).vertex_count;
  return part.block(cell.kind).to_vert.span().subspan(cell.index * n, n);
}

inline CellPlace neighbor_of(const PartMesh& part, CellPlace face) {
  return part.block(face.kind())
      .to_neighbor[std::size_t{face.cell()} * shape_of(face.kind()).face_count + face.place()];
}

/// Vertices of a face, counter-clockwise seen from outside its cell; the fourth is kNone for a triangle.
std::array<std::uint32_t, 4> vertices_of_face(const PartMesh& part, CellPlace face);
FaceKey key_of_face(const PartMesh& part, CellPlace face);
/// The same of a face, an edge or a boundary element, by its 2 to 4 vertices in any order.
FaceKey key_of_verts(std::span<const std::uint32_t> verts);

/// Computes everything that is derived from `to_vert` of the cells: neighbours, and the corners that vertices name.
/// Linear but for vertices with very many cells; needs no memory beside the result (unmatched faces are chained through
/// the neighbour arrays themselves). Where three or more cells share a face, two are linked and the others stay open.
/// Errors: OutOfMemory; InputUnsuitable beyond CellPlace's limits.
void connect_cells(PartMesh& part);
/// Gives back the memory of what connect_cells has made.
void disconnect_cells(PartMesh& part);

/// Calls visit(CellPlace) with the corner of every cell at `vert`, each once; in an order that depends on the mesh
/// only. The scratch keeps its memory between calls.
class BallFinder {
 public:
  explicit BallFinder(const PartMesh& part) : part_(part) {}
  /// The corners of all cells at `vert` (its ball). Valid until the next call.
  std::span<const CellPlace> find_ball(std::uint32_t vert);
  /// The cells that have both vertices (the shell of the edge between them); empty when there is no such edge.
  std::span<const CellId> find_shell(std::uint32_t a, std::uint32_t b);
  /// The face with exactly these vertices (3 or 4, any order), as a face of the lower of its cells; invalid if none.
  CellPlace find_face(std::span<const std::uint32_t> verts);

 private:
  const PartMesh& part_;
  std::vector<CellPlace> ball_;
  std::vector<CellId> shell_;
};

/// Calls visit(CellPlace) for each face without a cell of this part behind it: ascending.
template <class Visit>
void for_each_open_face(const PartMesh& part, Visit&& visit) {
  for (const CellKind kind : kAllCellKinds) {
    const CellBlock& block = part.block(kind);
    const std::uint32_t faces = shape_of(kind).face_count;
    for (std::uint32_t cell = 0; cell < block.size(); ++cell)
      for (std::uint32_t face = 0; face < faces; ++face)
        if (!block.to_neighbor[std::size_t{cell} * faces + face].valid()) visit(CellPlace(kind, cell, face));
  }
}

}  // namespace tetloom
