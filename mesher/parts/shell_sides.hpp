#pragma once
// On which side of the surface the tets of a part's shell lie that have surface points alone.
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "mesher/parts/shell_tets.hpp"

namespace tetloom::parts {

/// The shell of a part, its faces of the surface fixed. Refers to what must outlive it.
struct ShellView {
  const tets::TetMesh& mesh;
  std::uint32_t surface_count, first_outer;  ///< vertices: of the surface, then of the lattices, then outer ones
  std::span<const char> is_own_vert;         ///< per vertex that is no outer one: whether the part owns it
  ComplexTriangles known;
  std::span<const Box3> missing_boxes;  ///< of all triangles that the part knows and the shell does not have
};

/// Tets that hang together through faces that are none of the surface lie on one side of it: one tells of the others.
/// That holds where the part knows all of the surface, which it does between its own vertices, and where the shell has
/// it all; elsewhere a tet's centre tells. Remembers what it has found.
class ShellSides {
 public:
  ShellSides(const SharedInput& input, const ShellView& shell)
      : input_(input), shell_(shell), to_side_(shell.mesh.size(), Side::Unknown) {}

  /// Pre: the tet has surface points alone.
  bool is_inside(std::uint32_t tet);

 private:
  enum class Side : char { Unknown, Walked, Inside, Outside };

  bool walk(std::uint32_t tet);
  std::optional<bool> told_by(std::uint32_t tet) const;
  bool is_sure(std::uint32_t tet) const;
  bool is_at_outside(std::uint32_t tet) const;
  bool may_meet_missing(std::uint32_t tet) const;
  const std::uint32_t* verts(std::uint32_t tet) const { return &shell_.mesh.to_vert[std::size_t{tet} * 4]; }

  const SharedInput& input_;
  ShellView shell_;
  std::vector<Side> to_side_;
  std::vector<std::uint32_t> walked_;
};

}  // namespace tetloom::parts
