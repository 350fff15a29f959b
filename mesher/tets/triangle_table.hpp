#pragma once
// Finds triangles by their vertices, in any order.
#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <utility>
#include <vector>

#include "mesher/tets/tet_mesh.hpp"

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
inline TriangleVerts verts_of(const TetMesh& mesh, FaceCode face) {
  const std::uint32_t* v = mesh.to_vert.data() + std::size_t{face / 4} * 4;
  const auto& f = kFaceVerts[face % 4];
  return {v[f[0]], v[f[1]], v[f[2]]};
}

/// An open-addressing table of a fixed number of triangles; 32 bytes each at most. Lookups may run at once.
class TriangleTable {
 public:
  explicit TriangleTable(std::size_t count) : slots_(std::bit_ceil(count * 2 + 2)) {}

  struct Entry {
    TriangleVerts verts{kNone, kNone, kNone};  ///< ascending
    std::uint32_t value = 0;
    bool turned = false;  ///< the triangle added runs the other way round
  };
  /// False when it was there already. Pre: fewer triangles than announced were added.
  bool add(const TriangleVerts& triangle, std::uint32_t value) {
    const SortedTriangle key = sorted(triangle);
    Entry& slot = slots_[slot_of(key.verts)];
    if (slot.verts[0] != kNone) return false;
    slot = {key.verts, value, key.turned};
    return true;
  }
  /// nullptr when it is not there.
  const Entry* find(const SortedTriangle& triangle) const {
    const Entry& slot = slots_[slot_of(triangle.verts)];
    return slot.verts[0] == kNone ? nullptr : &slot;
  }

 private:
  // Where it stands, or the empty slot where it belongs.
  std::size_t slot_of(const TriangleVerts& verts) const {
    std::uint64_t hash = verts[0];
    for (const std::size_t i : {1, 2}) hash = (hash ^ hash >> 29) * 0x9e3779b97f4a7c15u + verts[i];
    hash = (hash ^ hash >> 32) * 0xbf58476d1ce4e5b9u;
    std::size_t slot = (hash ^ hash >> 31) & (slots_.size() - 1);
    while (slots_[slot].verts[0] != kNone && slots_[slot].verts != verts) slot = (slot + 1) & (slots_.size() - 1);
    return slot;
  }

  std::vector<Entry> slots_;
};

}  // namespace tetloom::tets
