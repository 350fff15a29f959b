#pragma once
// The edges between facets, any number of facets per edge. Private to core/discrete.
//
//            c                 Half-edge 3·tri + i runs from corner i to corner i + 1 of its triangle:
//           / \                here 3·tri is a→b, 3·tri + 1 is b→c, 3·tri + 2 is c→a.
//          /tri\               A facet *edge* joins two points; all half-edges between them, in either
//         a ─── b              direction, belong to it. *Regular* edges have two facets.
#include <algorithm>
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "core/base/lists.hpp"
#include "core/discrete/facet_soup.hpp"

namespace tetloom::detail {

constexpr std::uint32_t next_half(std::uint32_t half) { return half % 3 == 2 ? half - 2 : half + 1; }
constexpr std::uint32_t previous_half(std::uint32_t half) { return half % 3 == 0 ? half + 2 : half - 1; }
constexpr std::uint32_t half_to_tri(std::uint32_t half) { return half / 3; }

/// Edges with their vertices and the half-edges on them.
struct FacetEdges {
  std::vector<std::array<std::uint32_t, 2>> edge_to_vert;  ///< lower vertex first; edges sorted by their vertices
  std::vector<std::uint32_t> half_to_edge;
  std::vector<std::uint32_t> edge_to_offset;  ///< one more than there are edges
  std::vector<std::uint32_t> sorted_halves;   ///< ascending within an edge

  std::size_t size() const { return edge_to_vert.size(); }
  std::span<const std::uint32_t> halves(std::size_t edge) const {
    return std::span(sorted_halves).subspan(edge_to_offset[edge], edge_to_offset[edge + 1] - edge_to_offset[edge]);
  }
  /// Whether one of them has these ends.
  bool join(std::uint32_t a, std::uint32_t b) const {
    return std::ranges::binary_search(edge_to_vert, ascending(a, b));
  }
  /// The other half-edge of a regular edge.
  std::uint32_t twin(std::uint32_t half) const {
    const auto pair = halves(half_to_edge[half]);
    return pair[0] == half ? pair[1] : pair[0];
  }
  std::size_t open_count() const;     ///< edges of one facet
  std::size_t crowded_count() const;  ///< edges of three or more facets
};

/// Complexity: linear for bounded vertex degree. Pre: no triangle repeats a vertex.
FacetEdges find_edges(std::span<const Triangle> tri_to_vert, std::size_t point_count);

inline std::uint32_t half_origin(std::span<const Triangle> tris, std::uint32_t half) {
  return tris[half / 3][half % 3];
}
inline std::uint32_t half_head(std::span<const Triangle> tris, std::uint32_t half) {
  return tris[half / 3][(half + 1) % 3];
}

/// Twice the facet's area times its unit normal.
inline Vec3 facet_normal(std::span<const Vec3> points, const Triangle& t) {
  return cross(points[t[1]] - points[t[0]], points[t[2]] - points[t[0]]);
}

}  // namespace tetloom::detail
