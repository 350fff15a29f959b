#include "mesher/surface/narrow_tubes.hpp"

#include <algorithm>
#include <array>
#include <utility>
#include <vector>

namespace tetloom {
namespace {

using Ends = std::array<std::uint32_t, 2>;  // names of vertices, ascending

struct TubeEdge {
  Ends ends;
  std::uint32_t h = 0;
  friend auto operator<=>(const TubeEdge&, const TubeEdge&) = default;
};

// The places of a node have one name.
std::uint32_t name_of(const Patch& patch, std::uint32_t v) {
  constexpr std::uint32_t kInner = 0x80000000u;
  const std::uint32_t node = patch.vertices[v].node;
  return node != Triangulation::kNone ? node : kInner | v;
}

Ends ends_of(const Patch& patch, std::uint32_t h) {
  const std::uint32_t a = name_of(patch, patch.topology.origin(h)), b = name_of(patch, patch.topology.target(h));
  return {std::min(a, b), std::max(a, b)};
}

// Calls visit(edge) for one side of every edge.
template <class Visit>
void for_each_edge(const Patch& patch, const Visit& visit) {
  const Triangulation& topology = patch.topology;
  for (std::uint32_t h = 0; h < topology.half_edges(); ++h)
    if (topology.alive(h / 3) && (topology.twin(h) == Triangulation::kNone || topology.twin(h) > h))
      visit(TubeEdge{ends_of(patch, h), h});
}

// Edges between two places of a pole are none: all their points are the pole.
std::vector<TubeEdge> find_edges_around(const Patch& patch, const PatchSurface& surface) {
  constexpr double kNoLength = 1e-4;  // of the size
  std::vector<TubeEdge> around;
  for_each_edge(patch, [&](const TubeEdge& edge) {
    if (edge.ends[0] != edge.ends[1] || !is_inner_edge(patch.topology, edge.h)) return;
    const PatchVertex& a = patch.vertices[patch.topology.origin(edge.h)];
    const PatchPlace middle = surface.midpoint(a.place, patch.vertices[patch.topology.target(edge.h)].place);
    if (distance(middle.point, a.place.point) > kNoLength * a.size) around.push_back(edge);
  });
  return around;
}

// Appends the inner edges between vertices that another edge joins too.
void add_edges_alike(const Patch& patch, std::vector<TubeEdge>& found) {
  std::vector<TubeEdge> edges;
  for_each_edge(patch, [&](const TubeEdge& edge) {
    if (edge.ends[0] != edge.ends[1]) edges.push_back(edge);
  });
  std::ranges::sort(edges);
  for (std::size_t i = 0; i < edges.size(); ++i) {
    const bool is_repeated =
        (i > 0 && edges[i - 1].ends == edges[i].ends) || (i + 1 < edges.size() && edges[i + 1].ends == edges[i].ends);
    if (is_repeated && is_inner_edge(patch.topology, edges[i].h)) found.push_back(edges[i]);
  }
}

}  // namespace

void split_in_middle(Patch& patch, const PatchSurface& surface, std::uint32_t h) {
  Triangulation& topology = patch.topology;
  const PatchVertex &a = patch.vertices[topology.origin(h)], &b = patch.vertices[topology.target(h)];
  const PatchPlace middle = surface.midpoint(a.place, b.place);
  patch.vertices.push_back({middle, surface.size_at(middle.point), Triangulation::kNone});
  topology.split_edge(h, topology.add_vertex());
}

void open_narrow_tubes(Patch& patch, const PatchSurface& surface) {
  constexpr int kRounds = 6;
  std::vector<TubeEdge> edges = find_edges_around(patch, surface);
  for (int round = 0; round < kRounds && !edges.empty(); ++round) {
    for (const auto& [ends, h] : edges) {
      // A split before may have made another edge of it.
      const bool is_there =
          patch.topology.alive(h / 3) && is_inner_edge(patch.topology, h) && ends_of(patch, h) == ends;
      if (is_there) split_in_middle(patch, surface, h);
    }
    edges = find_edges_around(patch, surface);
    add_edges_alike(patch, edges);
  }
}

}  // namespace tetloom
