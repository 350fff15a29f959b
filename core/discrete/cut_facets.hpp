#pragma once
// Facets that cross each other cut along their common segments. Private to core/discrete.
#include <cstdint>
#include <span>
#include <vector>

#include "core/discrete/facet_piercings.hpp"

namespace tetloom::detail {

/// Facets that meet in whole edges. Four of them meet at each edge along which two facets crossed.
struct CutFacets {
  std::vector<Vec3> points;               ///< those given, then those of piercings, then those where three facets meet
  std::vector<Triangle> tris;             ///< oriented as what they are pieces of
  std::vector<std::uint32_t> tri_to_cut;  ///< the facet that each is a piece of
  std::vector<std::uint32_t>
      in_the_way;  ///< vertices, ascending, of facets that could not be cut: the rest is void then
};

/// Every facet is triangulated anew in its plane between the segments on it (constrained Delaunay), after Attene,
/// "Direct repair of self-intersecting meshes" (2014), but with new points rounded to doubles. Cost: linear, but for
/// the square of the segments on one facet. Errors: Cancelled.
CutFacets cut_facets(std::span<const Vec3> points, std::span<const Triangle> tris, const FacetEdges& edges,
                     std::span<const FacetPiercing> piercings, const CancelToken* cancel);

}  // namespace tetloom::detail
