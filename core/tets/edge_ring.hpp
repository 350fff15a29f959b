#pragma once
// The tets around an edge, and what takes their place when the edge is removed.
//
//            b
//          / | \           the ring r0, r1, ... of edge a-b, counter-clockwise seen from b; a triangulation of it
//        r0--|--r1  ...    with n - 2 triangles gives 2 (n - 2) tets in place of n
//          \ | /
//            a
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "core/tets/tet_mesh.hpp"

namespace tetloom::tets {

inline constexpr int kMostRingVerts = 12;  // that there is room for

/// The tets around the edge a-b: tet i is (a, b, verts[i], verts[i + 1]).
struct EdgeRing {
  std::uint32_t a = kNone, b = kNone;
  int count = 0;
  std::array<std::uint32_t, kMostRingVerts> verts, tets;

  std::span<const std::uint32_t> old() const { return {tets.data(), static_cast<std::size_t>(count)}; }
};

/// A triangle over a ring, by places in it: first < middle < last, which is counter-clockwise seen from b.
struct RingTriangle {
  std::uint8_t first, middle, last;
};

/// A triangulation of a ring; each triangle before those behind its two sides first-middle and middle-last.
struct RingTriangles {
  std::array<RingTriangle, kMostRingVerts - 2> items;
  int count = 0;

  std::span<const RingTriangle> list() const& { return {items.data(), static_cast<std::size_t>(count)}; }
  std::span<const RingTriangle> list() && = delete;
};

/// Of the two tets over a triangle, the vertices of the one at b and of the one at a, positively oriented.
inline std::array<std::array<std::uint32_t, 4>, 2> tets_over(const EdgeRing& ring, const RingTriangle& triangle) {
  const std::uint32_t p = ring.verts[triangle.first], q = ring.verts[triangle.middle], r = ring.verts[triangle.last];
  return {{{p, q, r, ring.b}, {p, r, q, ring.a}}};
}

}  // namespace tetloom::tets
