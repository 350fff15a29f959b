#pragma once
// The tetrahedra of one part while they are made: arrays like those of a PartMesh's tet block, and what making
// them needs beside.
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "core/tets/face_code.hpp"
#include "core/tets/tet_topology.hpp"
#include "tetloom/ids.hpp"
#include "tetloom/storage.hpp"
#include "tetloom/vec.hpp"

namespace tetloom::tets {

using tetloom::kNone;  // no tet, vertex, region or face

/// Struct of arrays, 37 bytes per tet and 24 per point. Tets have positive volume (orient3d > 0) in exact arithmetic.
///
/// `behind(face)` is the same face as a face of the tet behind it; not valid where there is none. Bit i of
/// `to_fixed[t]` says that face i must stay: it is a triangle of the given surface, and both tets beside it say so. A
/// dead tet has kNone as its first vertex; nothing points to it; `compact` drops it. Faces whose two tets lie in
/// different regions are fixed.
struct TetMesh {
  GrowingArray<Vec3> points;
  GrowingArray<std::uint32_t> to_vert;
  GrowingArray<FaceCode> to_neighbor;
  GrowingArray<std::uint32_t> to_region;
  GrowingArray<std::uint8_t> to_fixed;

  std::size_t size() const { return to_fixed.size(); }
  bool is_dead(std::uint32_t tet) const { return to_vert[std::size_t{tet} * 4] == kNone; }
  FaceRange faces() const { return {0, size()}; }
  FaceCode& behind(FaceCode face) { return to_neighbor[face.index()]; }
  FaceCode behind(FaceCode face) const { return to_neighbor[face.index()]; }
  /// The vertex that the face's tet has and the face has not.
  std::uint32_t apex(FaceCode face) const { return to_vert[face.index()]; }
  bool is_fixed(FaceCode face) const { return (to_fixed[face.tet()] >> face.side() & 1) != 0; }
  const Vec3& point_of(std::uint32_t tet, int corner) const { return points[to_vert[std::size_t{tet} * 4 + corner]]; }
};

/// Says of this side of a face that it must stay.
inline void fix_side(TetMesh& mesh, FaceCode face) {
  mesh.to_fixed[face.tet()] = static_cast<std::uint8_t>(mesh.to_fixed[face.tet()] | 1u << face.side());
}

/// Makes two faces the two sides of one; without a tet: nothing lies there.
inline void link_sides(TetMesh& mesh, FaceCode one, FaceCode other) {
  if (one.valid()) mesh.behind(one) = other;
  if (other.valid()) mesh.behind(other) = one;
}
/// The same, and where `fixed`, both must stay.
inline void link_sides(TetMesh& mesh, FaceCode one, FaceCode other, bool fixed) {
  link_sides(mesh, one, other);
  if (!fixed) return;
  if (one.valid()) fix_side(mesh, one);
  if (other.valid()) fix_side(mesh, other);
}

/// Calls move(from, to) until none of `count` places is a hole, with those from the end that are none for the holes,
/// which ascend. Returns how many are left.
template <class Move>
std::size_t fill_holes(std::size_t count, std::span<const std::uint32_t> holes, const Move& move) {
  std::size_t last = holes.size();
  for (std::size_t i = 0; i < last; ++i) {
    for (; last > i && holes[last - 1] == count - 1; --last) --count;
    if (i < last) move(static_cast<std::uint32_t>(--count), holes[i]);
  }
  return count;
}

/// Moves the last tets into the places of dead ones, in ascending order, so that none is dead. Linear.
void compact(TetMesh& mesh);
/// The same where the dead tets are known, ascending: what they leave is all that is looked at.
void compact(TetMesh& mesh, std::span<const std::uint32_t> dead);

/// What breaks the invariants of TetMesh first, in words; empty: nothing. Linear, with exact predicates.
std::string find_fault(const TetMesh& mesh);

/// The corner of `tet` at which `vertex` is. Pre: it is one.
inline std::uint32_t corner_of(const TetMesh& mesh, std::uint32_t tet, std::uint32_t vertex) {
  const std::uint32_t* verts = &mesh.to_vert[std::size_t{tet} * 4];
  return verts[0] == vertex ? 0 : verts[1] == vertex ? 1 : verts[2] == vertex ? 2 : 3;
}

}  // namespace tetloom::tets
