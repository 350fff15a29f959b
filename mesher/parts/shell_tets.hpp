#pragma once
// What decides whether a tet of a shell is one of the mesh, wherever that is asked.
#include <optional>
#include <span>

#include "mesher/parts/part_state.hpp"

namespace tetloom::parts {

Vec3 center_of(const tets::TetMesh& mesh, std::uint32_t tet);

/// Whether the point lies in the open ball around the tet; exact.
bool ball_holds(const tets::TetMesh& mesh, std::uint32_t tet, const Vec3& point);

/// The same for sites of lattices, most of them by a distance. Refers to the mesh.
class TetBall {
 public:
  TetBall(const tets::TetMesh& mesh, std::uint32_t tet);
  bool holds(const lattice::SiteLattice& lattice, const lattice::Site& site) const;

 private:
  const tets::TetMesh& mesh_;
  std::uint32_t tet_;
  Vec3 center_;
  double radius_ = -1;  // negative: not known well enough
};

/// Triangles of the complex by their vertices in a mesh.
struct ComplexTriangles {
  const tets::TriangleIndex& index;
  std::span<const std::uint32_t> triangles;  ///< of the complex, as numbered in the index
};

/// Whether the tet lies inside the surface, by the first of its fixed faces that is a triangle of it; nothing where
/// none is. Pre: fixed faces have vertices that the index counts.
std::optional<bool> is_inside_by_faces(const SharedInput& input, const tets::TetMesh& mesh, std::uint32_t tet,
                                       const ComplexTriangles& known);

/// By its centre.
bool is_inside_by_center(const SharedInput& input, const tets::TetMesh& mesh, std::uint32_t tet);

}  // namespace tetloom::parts
