#pragma once
// Clean facets with their edges, oriented leaf by leaf. Private to core/discrete.
//
// A *leaf* is a largest set of facets that can be walked across joints. An edge is a *joint* when exactly two facets
// meet there and their orientations agree. All other edges (open, of three or more facets, or where a one-sided
// surface such as a Möbius strip contradicts itself) bound leaves.
#include <cstdint>
#include <vector>

#include "core/discrete/facet_edges.hpp"
#include "core/discrete/facet_soup.hpp"

namespace tetloom::detail {

/// Clean, oriented facets with their edges and leaves.
struct FacetSurface {
  std::vector<Vec3> points;
  std::vector<Triangle> tri_to_vert;
  std::vector<std::uint32_t> tri_to_group;  ///< as in FacetSoup
  FacetEdges edges;
  std::vector<bool> edge_is_joint;
  std::vector<std::uint32_t> tri_to_leaf;  ///< leaves are numbered by their first facet
  std::uint32_t leaf_count = 0;

  std::uint32_t origin(std::uint32_t half) const { return half_origin(tri_to_vert, half); }
  std::uint32_t head(std::uint32_t half) const { return half_head(tri_to_vert, half); }
  std::uint32_t group(std::size_t tri) const { return tri_to_group.empty() ? 0 : tri_to_group[tri]; }
};

/// Takes the facets of a clean soup and turns facets over until each leaf is oriented as most of its facets were.
/// Returns the surface; `turned_over[tri]` says which facets now differ from the soup.
FacetSurface orient_facets(FacetSoup&& soup, std::vector<bool>& turned_over);

/// Turns whole leaves over, keeping `turned_over` up to date.
void turn_leaves_over(FacetSurface& surface, const std::vector<bool>& leaves, std::vector<bool>& turned_over);

}  // namespace tetloom::detail
