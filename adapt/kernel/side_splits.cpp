#include "adapt/kernel/side_splits.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <tuple>

#include "adapt/kernel/edge_split.hpp"

namespace tetloom::adapt {

namespace {

bool precedes(const SideEdge& a, const SideEdge& b) {
  return std::tuple(-a.length, a.names) < std::tuple(-b.length, b.names);
}

}  // namespace

// An edge as often as it has open faces in this part, with the tets of these.
std::vector<SideEdge> SideSplits::long_edges() const {
  std::vector<SideEdge> edges;
  for (const FaceCode face : mesh_.mesh.faces()) {
    if (mesh_.mesh.behind(face).valid()) continue;
    const Triangle verts = tets::verts_of(mesh_.mesh, face);
    if (!mesh_.to_frozen[verts[0]] || !mesh_.to_frozen[verts[1]] || !mesh_.to_frozen[verts[2]]) continue;
    for (std::size_t i = 0; i < 3; ++i) {
      SideEdge edge{.names = {}, .ends = {verts[i], verts[(i + 1) % 3]}, .tet = face.tet(), .entity = {}};
      if (names_[edge.ends[0]] > names_[edge.ends[1]]) std::swap(edge.ends[0], edge.ends[1]);
      edge.names = {names_[edge.ends[0]], names_[edge.ends[1]]};
      edge.length = static_cast<float>(mesh_.length_of(edge.ends[0], edge.ends[1]));
      if (edge.length > options_.longest) edges.push_back(edge);
    }
  }
  std::ranges::sort(edges, {}, [](const SideEdge& edge) { return std::tuple(edge.names, edge.tet); });
  return edges;
}

std::vector<SideEdge> SideSplits::find() {
  const std::vector<SideEdge> all = long_edges();
  std::vector<SideEdge> edges;
  std::ranges::unique_copy(all, std::back_inserter(edges), {}, &SideEdge::names);
  std::size_t begin = 0;
  for (SideEdge& edge : edges) {
    std::size_t end = begin;
    while (end < all.size() && all[end].names == edge.names) ++end;
    edge.refused = true;
    if (mesh_.collect(edge.ends, edge.tet, cavity_)) {
      edge.entity = entity_of_edge(mesh_, cavity_);
      // Tets of the part may lie at the edge in several places, with those of other parts between them.
      bool has_all = true;
      for (std::size_t i = begin; i < end; ++i)
        has_all = has_all && std::ranges::find(cavity_.tets, all[i].tet) != cavity_.tets.end();
      edge.refused = !has_all || !is_longest(edge, edges) || !can_split(edge);
    }
    begin = end;
  }
  return edges;
}

// Pre: cavity_ is that of the edge.
bool SideSplits::is_longest(const SideEdge& edge, std::span<const SideEdge> edges) const {
  for (const std::uint32_t tet : cavity_.tets) {
    for (const auto& [i, j] : tets::kEdgeVerts) {
      const std::uint32_t a = mesh_.verts(tet)[i], b = mesh_.verts(tet)[j];
      if (!mesh_.to_frozen[a] || !mesh_.to_frozen[b]) continue;
      const std::array<std::uint32_t, 2> names{std::min(names_[a], names_[b]), std::max(names_[a], names_[b])};
      const auto other = std::ranges::lower_bound(edges, names, {}, &SideEdge::names);
      if (other != edges.end() && other->names == names && precedes(*other, edge)) return false;
    }
  }
  return true;
}

// Pre: cavity_ is that of the edge.
bool SideSplits::can_split(const SideEdge& edge) {
  if (static_cast<double>(mesh_.mesh.size()) >= options_.most_tets) return false;
  const ModelEntity entity = edge.entity.unpack();
  if (options_.follows_model && entity.dim < 3) return false;
  if (entity.dim == 1 && (entity.index & kTouching) != 0) return false;
  const auto [a, b] = edge.ends;
  const double floor = floor_of_split(options_.floor, cavity_.least);
  const Tensor metric = 0.5 * (mesh_.to_metric[a].tensor + mesh_.to_metric[b].tensor);
  const std::uint32_t p = mesh_.add_vertex(place_of_split(mesh_, a, b), metric, edge.entity, mesh_.to_hint[a]);
  const bool good = mesh_.evaluate(cavity_, p, floor, made_) > floor;
  mesh_.drop_last_vertex();
  return good;
}

SideSpot SideSplits::spot(const SideEdge& edge) const {
  const auto [a, b] = edge.ends;
  SideSpot spot{place_of_split(mesh_, a, b), {}, mesh_.to_hint[a]};
  spot.metric = source_.at(spot.place, spot.hint);
  return spot;
}

void SideSplits::split(const SideEdge& edge, PackedEntity entity, const SideSpot& spot) {
  mesh_.collect(edge.ends, edge.tet, cavity_);
  const std::uint32_t p = mesh_.add_vertex(spot.place, spot.metric, entity, spot.hint);
  mesh_.to_frozen[p] = 1;
  mesh_.evaluate(cavity_, p, -1, made_);
  mesh_.reconnect(cavity_, p, made_);
}

}  // namespace tetloom::adapt
