#pragma once
// The faces of all cells, each known by a number, and which of them lie on each other.
#include <cstdint>
#include <span>
#include <vector>

#include "tetloom/host.hpp"
#include "tetloom/mesh_data.hpp"

namespace tetloom::detail {

/// Cells count as tets, pyramids, prisms, hexahedra; the faces of one cell follow each other, in the order of
/// `kCellShapes`. 8 bytes per face. Thread safety: const members from any thread.
class CellFaces {
 public:
  /// Linear, in parallel.
  CellFaces(const Mesh& mesh, const BlockLoop& loop);

  std::uint32_t size() const { return static_cast<std::uint32_t>(twin_.size()); }
  std::uint32_t cell_count() const { return first_cell_[kCellKinds]; }
  /// The cell that has the face, and which of its faces it is.
  std::uint32_t cell(std::uint32_t face) const;
  std::uint32_t local(std::uint32_t face) const;
  CellKind kind_of_cell(std::uint32_t cell) const;
  /// The first of the faces of a cell.
  std::uint32_t first_face(std::uint32_t cell) const;
  /// The face of another cell that has the same vertices; kNone where there is none.
  std::uint32_t twin(std::uint32_t face) const { return twin_[face]; }
  /// Writes the vertices of a face, counter-clockwise seen from outside of its cell; three or four.
  std::span<const std::uint32_t> vertices(std::uint32_t face, std::span<std::uint32_t, 4> out) const;
  /// The lowest face of a cell with these vertices, in any order; kNone where there is none.
  std::uint32_t find(std::span<const std::uint32_t> verts) const;
  /// The same of a triangle or quadrilateral of the mesh, by its number among them, triangles first.
  std::uint32_t find_surface(std::uint32_t element) const;
  /// The face that `find_surface` finds, or its twin where that is of a region with a lower tag: so all sides of a face
  /// between two regions belong to the same of them.
  std::uint32_t find_side(std::uint32_t element) const;

 private:
  std::uint32_t region_of(std::uint32_t face) const;
  std::size_t kind_of_face(std::uint32_t face) const;

  const Mesh& mesh_;
  std::uint32_t first_cell_[kCellKinds + 1] = {}, first_face_[kCellKinds + 1] = {};
  std::vector<std::uint32_t> first_at_, faces_at_;  // per vertex: faces of which it is the lowest vertex, ascending
  std::vector<std::uint32_t> twin_;
};

}  // namespace tetloom::detail
