#include "core/discrete/facet_surface.hpp"

#include <utility>

namespace tetloom::detail {
namespace {

/// For each facet its leaf, or kNone, and whether it has to be turned over to agree with the leaf's first facet.
struct Flood {
  std::vector<std::uint32_t> tri_to_leaf;
  std::vector<bool> turn;
  std::uint32_t leaf_count = 0;
};

bool run_alike(const FacetSurface& surface, std::uint32_t half, std::uint32_t other) {
  return surface.origin(half) == surface.origin(other);
}

/// Walks over one leaf from `seed`; turns the minority over.
void flood_leaf(const FacetSurface& surface, std::uint32_t seed, Flood& flood) {
  std::vector<std::uint32_t> reached{seed};
  std::size_t turned = 0;
  flood.tri_to_leaf[seed] = flood.leaf_count;
  for (std::size_t next = 0; next < reached.size(); ++next) {
    for (std::uint32_t half = 3 * reached[next]; half < 3 * reached[next] + 3; ++half) {
      if (surface.edges.halves(surface.edges.half_to_edge[half]).size() != 2) continue;
      const std::uint32_t other = surface.edges.twin(half), tri = half_to_tri(other);
      if (flood.tri_to_leaf[tri] != kNone) continue;
      flood.tri_to_leaf[tri] = flood.leaf_count;
      flood.turn[tri] = flood.turn[reached[next]] != run_alike(surface, half, other);
      turned += flood.turn[tri];
      reached.push_back(tri);
    }
  }
  if (2 * turned > reached.size()) {
    for (const std::uint32_t tri : reached) flood.turn[tri] = !flood.turn[tri];
  }
  ++flood.leaf_count;
}

bool turn_facets_over(FacetSurface& surface, const std::vector<bool>& turn) {
  bool any = false;
  for (std::size_t tri = 0; tri < turn.size(); ++tri) {
    if (!turn[tri]) continue;
    std::swap(surface.tri_to_vert[tri][1], surface.tri_to_vert[tri][2]);
    any = true;
  }
  if (any) surface.edges = find_edges(surface.tri_to_vert, surface.points.size());
  return any;
}

}  // namespace

FacetSurface orient_facets(FacetSoup&& soup, std::vector<bool>& turned_over) {
  FacetSurface surface;
  surface.points = std::move(soup.points);
  surface.tri_to_vert = std::move(soup.tri_to_vert);
  surface.tri_to_group = std::move(soup.tri_to_group);
  surface.edges = find_edges(surface.tri_to_vert, surface.points.size());
  const std::size_t count = surface.tri_to_vert.size();
  Flood flood{std::vector<std::uint32_t>(count, kNone), std::vector<bool>(count, false)};
  for (std::uint32_t tri = 0; tri < count; ++tri) {
    if (flood.tri_to_leaf[tri] == kNone) flood_leaf(surface, tri, flood);
  }
  turn_facets_over(surface, flood.turn);
  turned_over = std::move(flood.turn);
  surface.tri_to_leaf = std::move(flood.tri_to_leaf), surface.leaf_count = flood.leaf_count;
  surface.edge_is_joint.resize(surface.edges.size());
  for (std::size_t edge = 0; edge < surface.edges.size(); ++edge) {
    const auto halves = surface.edges.halves(edge);
    surface.edge_is_joint[edge] = halves.size() == 2 && !run_alike(surface, halves[0], halves[1]);
  }
  return surface;
}

void turn_leaves_over(FacetSurface& surface, const std::vector<bool>& leaves, std::vector<bool>& turned_over) {
  std::vector<bool> turn(surface.tri_to_vert.size());
  for (std::size_t tri = 0; tri < turn.size(); ++tri) turn[tri] = leaves[surface.tri_to_leaf[tri]];
  if (!turn_facets_over(surface, turn)) return;
  for (std::size_t tri = 0; tri < turn.size(); ++tri) turned_over[tri] = turned_over[tri] != turn[tri];
}

}  // namespace tetloom::detail
