#pragma once
// Mending surfaces of facets where they are open. Private to core/discrete.
#include "core/discrete/facet_edges.hpp"
#include "core/discrete/facet_soup.hpp"

namespace tetloom::detail {

/// Cuts facets whose open edge passes points of other open edges (T-junctions) at these points, where that leaves fewer
/// edges open: within 1e-5 of the bounding box's diagonal. Returns how many facets were cut. Errors: Cancelled.
std::size_t close_t_junctions(FacetSoup& soup, const CancelToken* cancel);

/// A connected set of open edges.
struct OpenRim {
  std::vector<std::uint32_t> verts;  ///< in order; empty where the edges are no simple loop
  std::size_t edges = 0;
  double width = 0;  ///< diagonal of the edges' box
  Vec3 point;        ///< of the set, the middle of its first edge
};

/// In the order of their first edges.
std::vector<OpenRim> find_open_rims(std::span<const Vec3> points, const FacetEdges& edges);

/// Fills the holes that are at most `width` wide and whose rim is a simple loop, with facets between the rim's points
/// or, where these would meet others, around one point in their middle. Returns how many holes. Errors: Cancelled.
std::size_t fill_holes(FacetSoup& soup, double width, const CancelToken* cancel);

}  // namespace tetloom::detail
