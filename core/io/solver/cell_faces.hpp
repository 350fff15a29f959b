#pragma once
// The faces of all cells, each known by a number, and which of them lie on each other.
#include <cstdint>
#include <span>
#include <vector>

#include "tetloom/host.hpp"
#include "tetloom/mesh_data.hpp"

namespace tetloom::detail {

/// Which faces are looked up: those of all cells, or those whose vertices all lie on the surface of the mesh.
enum class FacesOf : std::uint8_t { AllCells, Surface };

/// Cells count as tets, pyramids, prisms, hexahedra; the faces of one cell follow each other, in the order of
/// `kCellShapes`. 8 bytes per face that is looked up. Thread safety: const members from any thread.
class CellFaces {
 public:
  /// Linear, in parallel. `find`, `find_surface`, `find_side` and `twin` know the faces of `which` alone.
  CellFaces(const Mesh& mesh, const BlockLoop& loop, FacesOf which = FacesOf::AllCells);

  std::uint32_t size() const { return first_face_[kCellKinds]; }
  std::uint32_t cell_count() const { return first_cell_[kCellKinds]; }
  /// The cell that has the face, and which of its faces it is.
  std::uint32_t cell(std::uint32_t face) const;
  std::uint32_t local(std::uint32_t face) const;
  CellKind kind_of_cell(std::uint32_t cell) const;
  /// The first of the faces of a cell.
  std::uint32_t first_face(std::uint32_t cell) const;
  /// The face of another cell that has the same vertices; kNone where there is none.
  std::uint32_t twin(std::uint32_t face) const;
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
  std::vector<std::uint32_t> surface_faces(const BlockLoop& loop) const;
  void sort_by_lowest_vertex(const BlockLoop& loop);
  void find_twins(const BlockLoop& loop);
  std::uint32_t known_face(std::size_t i) const { return knows_all_ ? static_cast<std::uint32_t>(i) : known_[i]; }
  std::size_t place(std::uint32_t face) const;  // in `twin_`
  std::uint32_t region_of(std::uint32_t face) const;
  std::size_t kind_of_face(std::uint32_t face) const;

  const Mesh& mesh_;
  std::uint32_t first_cell_[kCellKinds + 1] = {}, first_face_[kCellKinds + 1] = {};
  bool knows_all_ = true;
  std::vector<std::uint32_t> known_;                // unless all are looked up: those that are, ascending
  std::vector<std::uint32_t> first_at_, faces_at_;  // per vertex: known faces of which it is the lowest, ascending
  std::vector<std::uint32_t> twin_;                 // per known face
};

}  // namespace tetloom::detail
