#pragma once
// The triangles of a surface with what stands around each point, while edges of it are swapped.
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "core/tets/triangle_verts.hpp"

namespace tetloom::tets {

/// Refers to the triangles and changes them in place. Besides them: 12 bytes per triangle, 4 per point.
class SurfaceTriangles {
 public:
  /// Pre: indices are below `point_count`.
  SurfaceTriangles(std::span<TriangleVerts> tri_to_vert, std::size_t point_count);

  const TriangleVerts& verts(std::uint32_t triangle) const { return tri_to_vert_[triangle]; }

  /// Calls visit(triangle) for those at `vertex`, in an order that depends on what was built and swapped alone.
  template <class Visit>
  void for_each_at(std::uint32_t vertex, Visit&& visit) const {
    if (vertex >= first_.size()) return;
    for (std::uint32_t corner = first_[vertex]; corner != kNone; corner = next_[corner]) visit(corner / 3);
  }
  bool has_edge(std::uint32_t a, std::uint32_t b) const;

  /// Two triangles at an edge that run through it one way and the other: (a, b, p) and (b, a, q).
  ///
  ///        p                 p
  ///       / \              / | \        after a swap: (a, q, p) and (q, b, p)
  ///      a---b            a  |  b
  ///       \ /              \ | /
  ///        q                 q
  struct Diamond {
    std::uint32_t left = kNone, right = kNone;  ///< triangles
    std::uint32_t a = kNone, b = kNone, p = kNone, q = kNone;

    std::array<TriangleVerts, 2> before() const { return {{{a, b, p}, {b, a, q}}}; }
    std::array<TriangleVerts, 2> after() const { return {{{a, q, p}, {q, b, p}}}; }
  };
  /// False when the edge has not exactly two triangles, or they do not run through it both ways.
  bool find_diamond(std::uint32_t a, std::uint32_t b, Diamond& diamond) const;
  void swap(const Diamond& diamond);

 private:
  void add(std::uint32_t triangle, const TriangleVerts& verts);
  void remove(std::uint32_t triangle);

  std::span<TriangleVerts> tri_to_vert_;
  std::vector<std::uint32_t> first_, next_;  // per point its first corner, per corner (triangle * 3 + i) the next one
};

}  // namespace tetloom::tets
