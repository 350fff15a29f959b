#include "core/discrete/facet_edges.hpp"

#include <algorithm>

namespace tetloom::detail {
namespace {

struct HalfKey {
  std::uint32_t high_vertex, half;
  friend auto operator<=>(const HalfKey&, const HalfKey&) = default;
};

/// Half-edges in buckets by their lower vertex, each bucket sorted by higher vertex and half-edge.
struct HalfBuckets {
  std::vector<std::uint32_t> offset;
  std::vector<HalfKey> keys;
};

HalfBuckets sort_halves(std::span<const Triangle> tris, std::size_t point_count) {
  HalfBuckets buckets{std::vector<std::uint32_t>(point_count + 1, 0), std::vector<HalfKey>(3 * tris.size())};
  const auto for_each_half = [&](auto&& visit) {
    for (std::uint32_t half = 0; half < 3 * tris.size(); ++half) {
      const auto [low, high] = std::minmax({half_origin(tris, half), half_head(tris, half)});
      visit(low, HalfKey{high, half});
    }
  };
  for_each_half([&](std::uint32_t low, const HalfKey&) { ++buckets.offset[low + 1]; });
  for (std::size_t v = 0; v < point_count; ++v) buckets.offset[v + 1] += buckets.offset[v];
  std::vector<std::uint32_t> fill(buckets.offset.begin(), buckets.offset.end() - 1);
  for_each_half([&](std::uint32_t low, const HalfKey& key) { buckets.keys[fill[low]++] = key; });
  for (std::size_t v = 0; v < point_count; ++v) {
    std::sort(buckets.keys.begin() + buckets.offset[v], buckets.keys.begin() + buckets.offset[v + 1]);
  }
  return buckets;
}

}  // namespace

std::size_t FacetEdges::open_count() const {
  std::size_t count = 0;
  for (std::size_t edge = 0; edge < size(); ++edge) count += halves(edge).size() == 1;
  return count;
}

std::size_t FacetEdges::crowded_count() const {
  std::size_t count = 0;
  for (std::size_t edge = 0; edge < size(); ++edge) count += halves(edge).size() > 2;
  return count;
}

FacetEdges find_edges(std::span<const Triangle> tri_to_vert, std::size_t point_count) {
  const HalfBuckets buckets = sort_halves(tri_to_vert, point_count);
  FacetEdges edges;
  edges.half_to_edge.resize(3 * tri_to_vert.size());
  edges.sorted_halves.reserve(3 * tri_to_vert.size());
  edges.edge_to_vert.reserve(3 * tri_to_vert.size() / 2 + 1),
      edges.edge_to_offset.reserve(3 * tri_to_vert.size() / 2 + 2);
  for (std::uint32_t low = 0; low < point_count; ++low) {
    for (std::uint32_t i = buckets.offset[low]; i < buckets.offset[low + 1]; ++i) {
      const HalfKey& key = buckets.keys[i];
      if (i == buckets.offset[low] || buckets.keys[i - 1].high_vertex != key.high_vertex) {
        edges.edge_to_offset.push_back(static_cast<std::uint32_t>(edges.sorted_halves.size()));
        edges.edge_to_vert.push_back({low, key.high_vertex});
      }
      edges.half_to_edge[key.half] = static_cast<std::uint32_t>(edges.edge_to_vert.size() - 1);
      edges.sorted_halves.push_back(key.half);
    }
  }
  edges.edge_to_offset.push_back(static_cast<std::uint32_t>(edges.sorted_halves.size()));
  return edges;
}

}  // namespace tetloom::detail
