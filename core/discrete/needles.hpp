#pragma once
// Facets with a side too short to mean anything. Private to core/discrete.
#include "core/discrete/facet_soup.hpp"

namespace tetloom::detail {

/// Merges the ends of edges between two facets that are shorter than 1e-5 of the bounding box's diagonal, shortest
/// first, where that keeps the surface a manifold as far as it was one and turns no facet over that has a normal.
/// Returns how many points disappeared. Deterministic. Errors: Cancelled.
std::size_t collapse_needles(FacetSoup& soup, const CancelToken* cancel);

}  // namespace tetloom::detail
