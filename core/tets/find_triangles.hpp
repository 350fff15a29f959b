#pragma once
// Which triangles are faces of the mesh.
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "core/tets/triangle_verts.hpp"
#include "tetloom/host.hpp"

namespace tetloom::tets {

/// Triangles by their lowest vertex. Where numbers of neighbours are near each other, as those of surface points are,
/// lookups stay in the cache, other than those of a hash table. 16 bytes per triangle, 4 per point.
class TriangleIndex {
 public:
  /// Triangles with vertices from `point_count` on are left out.
  TriangleIndex(std::span<const TriangleVerts> triangles, std::size_t point_count);

  struct Entry {
    std::uint32_t middle, highest;
    std::uint32_t triangle;
    bool turned;  ///< runs the other way round than its vertices ascending
  };
  /// The first of those with these vertices; nullptr where there is none. Pre: vertices below the number of points.
  const Entry* find(const SortedTriangle& key) const {
    const Entry* end = entries_.data() + vert_to_end_[key.verts[0]];
    const Entry* begin = key.verts[0] == 0 ? entries_.data() : entries_.data() + vert_to_end_[key.verts[0] - 1];
    for (; begin != end; ++begin) {
      if (begin->middle == key.verts[1] && begin->highest == key.verts[2]) return begin;
    }
    return nullptr;
  }

 private:
  std::vector<Entry> entries_;  // those of a vertex ascend in `triangle`
  std::vector<std::uint32_t> vert_to_end_;
};

/// The same in a quarter of the memory, for few lookups in many triangles: each reads the triangles at a vertex. Refers
/// to the triangles.
class TrianglesByVertex {
 public:
  /// Pre: vertices below `point_count`.
  TrianglesByVertex(std::span<const TriangleVerts> triangles, std::size_t point_count);

  /// The first of those with these vertices; nothing where there is none. Pre: vertices below the number of points.
  std::optional<std::uint32_t> find(const SortedTriangle& key) const;

 private:
  std::span<const TriangleVerts> triangles_;
  std::vector<std::uint32_t> by_vertex_;  // those of a vertex ascend
  std::vector<std::uint32_t> vert_to_end_;
};

/// For every triangle the face of the tet on its front side (the side from which it is counter-clockwise), kNone where
/// it is no face of the mesh. Linear.
std::vector<FaceCode> find_triangles(const TetMesh& mesh, std::span<const TriangleVerts> triangles,
                                     const BlockLoop& loop);

/// The same for triangles that are in `index`; of repeated ones the first has the face, others kNone.
std::vector<FaceCode> find_triangles(const TetMesh& mesh, std::span<const TriangleVerts> triangles,
                                     const TriangleIndex& index, const BlockLoop& loop);

/// Fixes the triangles that are faces of the mesh, on both sides, and returns the others and the repeated ones,
/// ascending.
std::vector<std::uint32_t> fix_triangles(TetMesh& mesh, std::span<const TriangleVerts> triangles,
                                         const TriangleIndex& index, const BlockLoop& loop);

}  // namespace tetloom::tets
