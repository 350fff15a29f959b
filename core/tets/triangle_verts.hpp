#pragma once
// Triangles as their vertices, to be compared in any order.
#include <algorithm>
#include <array>
#include <cstdint>
#include <utility>

#include "core/tets/tet_mesh.hpp"

namespace tetloom::tets {

using TriangleVerts = std::array<std::uint32_t, 3>;

/// The vertices ascending, and whether the order was turned (an odd permutation) for that.
struct SortedTriangle {
  TriangleVerts verts;
  bool turned = false;
};
inline SortedTriangle sorted(TriangleVerts v) {
  bool turned = false;
  const auto order = [&](std::size_t i, std::size_t j) {
    if (v[i] > v[j]) std::swap(v[i], v[j]), turned = !turned;
  };
  order(0, 1), order(1, 2), order(0, 1);
  return {v, turned};
}

/// The vertices of a face, counter-clockwise seen from outside its tet.
inline TriangleVerts verts_of(const std::uint32_t* tet_to_vert, FaceCode face) {
  const std::uint32_t* v = tet_to_vert + std::size_t{face.tet()} * 4;
  const auto& f = kFaceVerts[face.side()];
  return {v[f[0]], v[f[1]], v[f[2]]};
}
inline TriangleVerts verts_of(const TetMesh& mesh, FaceCode face) { return verts_of(mesh.to_vert.data(), face); }

}  // namespace tetloom::tets
