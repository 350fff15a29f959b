#include "mesher/surface/narrow_tubes.hpp"

#include <algorithm>
#include <vector>

namespace tetloom {
namespace {

std::uint32_t name_of(const Patch& patch, std::uint32_t v) {
  const std::uint32_t node = patch.vertices[v].node;
  return node != Triangulation::kNone ? node : NamedEdge::kInnerVertex | v;
}

// Calls visit(edge) for one side of every edge.
template <class Visit>
void for_each_edge(const Patch& patch, const Visit& visit) {
  const Triangulation& topology = patch.topology;
  for (std::uint32_t h = 0; h < topology.half_edges(); ++h)
    if (topology.alive(h / 3) && (topology.twin(h) == Triangulation::kNone || topology.twin(h) > h))
      visit(named_edge(patch, h));
}

// Edges between two places of a pole are none: all their points are the pole.
std::vector<NamedEdge> find_edges_around(const Patch& patch, const PatchSurface& surface) {
  constexpr double kNoLength = 1e-4;  // of the size
  std::vector<NamedEdge> around;
  for_each_edge(patch, [&](const NamedEdge& edge) {
    if (edge.ends[0] != edge.ends[1] || !is_inner_edge(patch.topology, edge.h)) return;
    const PatchVertex& a = patch.vertices[patch.topology.origin(edge.h)];
    const PatchPlace middle = surface.midpoint(a.place, patch.vertices[patch.topology.target(edge.h)].place);
    if (distance(middle.point, a.place.point) > kNoLength * a.size) around.push_back(edge);
  });
  return around;
}

}  // namespace

NamedEdge named_edge(const Patch& patch, std::uint32_t h) {
  const std::uint32_t a = name_of(patch, patch.topology.origin(h)), b = name_of(patch, patch.topology.target(h));
  return {{std::min(a, b), std::max(a, b)}, h};
}

std::vector<NamedEdge> find_edges_alike(const Patch& patch) {
  std::vector<NamedEdge> edges, alike;
  for_each_edge(patch, [&](const NamedEdge& edge) {
    if (edge.ends[0] != edge.ends[1]) edges.push_back(edge);
  });
  std::ranges::sort(edges);
  for (std::size_t i = 0; i < edges.size(); ++i) {
    const bool is_repeated =
        (i > 0 && edges[i - 1].ends == edges[i].ends) || (i + 1 < edges.size() && edges[i + 1].ends == edges[i].ends);
    if (is_repeated && is_inner_edge(patch.topology, edges[i].h)) alike.push_back(edges[i]);
  }
  return alike;
}

void split_in_middle(Patch& patch, const PatchSurface& surface, std::uint32_t h) {
  Triangulation& topology = patch.topology;
  const PatchVertex &a = patch.vertices[topology.origin(h)], &b = patch.vertices[topology.target(h)];
  const PatchPlace middle = surface.midpoint(a.place, b.place);
  patch.vertices.push_back({middle, surface.size_at(middle.point), Triangulation::kNone});
  topology.split_edge(h, topology.add_vertex());
}

void open_narrow_tubes(Patch& patch, const PatchSurface& surface) {
  constexpr int kRounds = 6;
  std::vector<NamedEdge> edges = find_edges_around(patch, surface);
  for (int round = 0; round < kRounds && !edges.empty(); ++round) {
    for (const NamedEdge& edge : edges) {
      // A split before may have made another edge of it.
      const bool is_there = patch.topology.alive(edge.h / 3) && is_inner_edge(patch.topology, edge.h) &&
                            named_edge(patch, edge.h) == edge;
      if (is_there) split_in_middle(patch, surface, edge.h);
    }
    edges = find_edges_around(patch, surface);
    const std::vector<NamedEdge> alike = find_edges_alike(patch);
    edges.insert(edges.end(), alike.begin(), alike.end());
  }
}

}  // namespace tetloom
