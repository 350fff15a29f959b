#pragma once
// Where edges of facets pass through other facets. Private to core/discrete.
#include <cstdint>
#include <span>
#include <vector>

#include "core/discrete/facet_edges.hpp"

namespace tetloom::detail {

/// An edge passes through the inside of a facet that has none of its ends.
struct FacetPiercing {
  std::uint32_t edge = 0, tri = 0;
  Vec3 point;
  double share = 0;  ///< of the edge, from its lower vertex
};

/// All piercings, by edge and then by facet, or the vertices that are in the way of a decision: they lie on a facet, or
/// their edge meets another edge. Facets in one plane with a vertex in common are passed over.
struct FacetPiercings {
  std::vector<FacetPiercing> all;
  std::vector<std::uint32_t> in_the_way;  ///< ascending
};

/// Decided exactly. Complexity: O(n log n) for facets that meet few others. Errors: Cancelled.
FacetPiercings find_piercings(std::span<const Vec3> points, std::span<const Triangle> tris, const FacetEdges& edges,
                              const CancelToken* cancel);

}  // namespace tetloom::detail
