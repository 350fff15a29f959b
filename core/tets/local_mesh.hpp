#pragma once
// Walks around vertices and edges of a tetrahedral mesh, and the one change there is: some tets for others that fill
// the same polyhedron.
#include <array>
#include <cstdint>
#include <span>
#include <unordered_set>
#include <vector>

#include "core/tets/tet_editor.hpp"
#include "core/tets/tet_mesh.hpp"
#include "core/tets/triangle_verts.hpp"

namespace tetloom::tets {

using Tet = std::array<std::uint32_t, 4>;
using TetList = std::vector<std::uint32_t>;

/// A mesh that is changed in one place after the other.
class LocalMesh {
 public:
  /// Linear in the mesh.
  explicit LocalMesh(TetMesh& mesh);

  const TetMesh& mesh() const { return mesh_; }
  const Vec3& point(std::uint32_t v) const { return mesh_.points[v]; }
  Tet tet(std::uint32_t t) const;
  bool has(std::uint32_t t, std::uint32_t v) const { return corner_of(t, v) < 4; }
  std::uint32_t corner_of(std::uint32_t t, std::uint32_t v) const;
  /// As the inside of the tet sees it, counter-clockwise.
  TriangleVerts face(FaceCode code) const;

  /// The tets at a vertex; none where no tet has it.
  TetList find_ball(std::uint32_t v) const;
  /// The tets at an edge; none where the mesh does not have it.
  TetList find_shell(std::uint32_t a, std::uint32_t b) const;
  bool has_edge(std::uint32_t a, std::uint32_t b) const { return !find_shell(a, b).empty(); }
  /// The face as one of the tet that sees a, b, c counter-clockwise; kNone where the mesh does not have it.
  FaceCode find_face(const TriangleVerts& triangle) const;

  void fix(FaceCode code);
  void release(FaceCode code);

  /// The tets `fresh` take the place of `old`. Fixed faces stay fixed, those of the boundary as well as those inside
  /// that are still there. Pre: all of `fresh` have positive volume and the boundary of both is the same.
  void replace(std::span<const std::uint32_t> old, std::span<const Tet> fresh);
  std::uint32_t add_point(const Vec3& p);
  void move_point(std::uint32_t v, const Vec3& p) { mesh_.points[v] = p; }

  /// Drops dead tets, and points from `first` on that no tet has; ids of tets and of those points change.
  void tidy(std::uint32_t first);

 private:
  // All tets that `keep` accepts and that are connected to `seed` through faces of such tets.
  template <class Keep>
  void flood(std::uint32_t seed, const Keep& keep, TetList& tets) const;

  TetMesh& mesh_;
  std::vector<std::uint32_t> vert_to_tet_;
  TetEditor editor_;
  mutable std::vector<std::uint32_t> stamps_;
  mutable std::uint32_t stamp_ = 0;
};

}  // namespace tetloom::tets
