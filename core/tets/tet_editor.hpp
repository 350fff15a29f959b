#pragma once
// The one change that a mesh of tets undergoes: some of them give way to others that fill the same polyhedron.
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/tets/cavity_filling.hpp"
#include "core/tets/tet_mesh.hpp"
#include "core/tets/triangle_verts.hpp"

namespace tetloom::tets {

/// What stands for the cubed quality of a dead tet, where qualities are kept: better than any.
inline constexpr float kDeadQuality = 2;

/// The vertices of a tet, positively oriented, and its cubed quality.
struct NewTet {
  std::array<std::uint32_t, 4> verts;
  double quality;
};

/// The tets `made` take the place of `old`.
struct Replacement {
  std::span<const std::uint32_t> old;
  std::span<const NewTet> made;
  std::span<const std::uint32_t> regions = {};             ///< of each that is made; empty: all have that of old[0]
  std::span<const TriangleVerts> before = {}, after = {};  ///< triangles of the surface, as for CavityFilling
};

/// Dead tets form a list through their first neighbour, so that nothing is allocated for them. `to_quality`, where it
/// is not nullptr, has a value for each tet of the mesh and is kept so.
class TetEditor {
 public:
  /// New tets take the ids of old ones in the order of `old`, then those of dead tets, the last that died first, then
  /// new ones. What is left of `old` dies in its order. Returns the ids, valid until the next call. Pre: what is made
  /// has positive volumes and the boundary of the cavity. Post: links, fixed faces, regions and qualities are right;
  /// faces that were fixed stay so, on the boundary as well as those inside that are still there.
  std::span<const std::uint32_t> replace(TetMesh& mesh, GrowingArray<float>* to_quality, const Replacement& what);

  /// The same without links, where the caller knows them: those of new tets and of what lies behind them are still to
  /// be set, and so are fixed faces. `before` and `after` are not looked at.
  std::span<const std::uint32_t> write(TetMesh& mesh, GrowingArray<float>* to_quality, const Replacement& what);

  /// The tet is dead now. Pre: nothing points to it.
  void drop(TetMesh& mesh, GrowingArray<float>* to_quality, std::uint32_t tet);

  /// The dead tets, which are in the list, have been dropped by `compact`.
  void forget_dead() { first_dead_ = {}; }

  /// The beginning of the list, for an editor that goes on with the same mesh.
  FaceCode first_dead() const { return first_dead_; }
  void set_first_dead(FaceCode face) { first_dead_ = face; }

 private:
  std::uint32_t take(TetMesh& mesh, GrowingArray<float>* to_quality);

  FaceCode first_dead_;  // first face of the last tet that died; behind it lies the one before
  CavityFilling filling_;
  std::vector<std::uint32_t> ids_;
};

}  // namespace tetloom::tets
