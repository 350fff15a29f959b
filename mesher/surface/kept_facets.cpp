#include "mesher/surface/kept_facets.hpp"

#include <algorithm>
#include <map>
#include <utility>

#include "core/spatial/distances.hpp"

namespace tetloom {
namespace {

struct Node {
  double t = 0;
  Vec3 point;
  bool is_kept = false;
};

// Whether a piece of the edge reaches into a ball.
bool reaches(const EdgeMesh& edge, std::span<const KeptPlace> places) {
  for (std::size_t i = 0; i + 1 < edge.points.size(); ++i)
    for (const auto& [center, radius] : places)
      if (distance_to_segment(center, edge.points[i], edge.points[i + 1]) < radius) return true;
  return false;
}

// The nodes inside of the balls and the others, in their order along the edge.
std::vector<Node> all_nodes(const EdgeMesh& edge, std::span<const Node> kept, const KeptFacets& facets) {
  std::vector<Node> nodes(kept.begin(), kept.end());
  const std::size_t last = edge.t.size() - 1;
  for (std::size_t i = 0; i <= last; ++i) {
    const bool is_end = i == 0 || i == last;
    if (is_end || !facets.holds(edge.points[i])) nodes.push_back({edge.t[i], edge.points[i], is_end});
  }
  std::ranges::stable_sort(nodes, {}, &Node::t);
  return nodes;
}

// Without those that are not kept and too near to one that is.
std::vector<Node> spread(const std::vector<Node>& nodes, double spacing) {
  constexpr double kNear = 1.0 / 3;
  std::vector<Node> result;
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    const auto is_near = [&](std::size_t other) {
      return nodes[other].is_kept && distance(nodes[i].point, nodes[other].point) < kNear * spacing;
    };
    const bool goes = !nodes[i].is_kept && ((i > 0 && is_near(i - 1)) || (i + 1 < nodes.size() && is_near(i + 1)));
    if (!goes && (result.empty() || nodes[i].t > result.back().t)) result.push_back(nodes[i]);
  }
  return result;
}

void put_nodes(const std::vector<Node>& kept, const KeptFacets& facets, EdgeMesh& edge) {
  double length = 0;
  for (std::size_t i = 0; i + 1 < edge.points.size(); ++i) length += distance(edge.points[i], edge.points[i + 1]);
  const double spacing = length / static_cast<double>(edge.points.size() - 1);
  const auto [first, last] = std::pair(edge.points.front(), edge.points.back());
  const std::vector<Node> nodes = spread(all_nodes(edge, kept, facets), spacing);
  edge.t.clear(), edge.points.clear();
  for (const Node& node : nodes) edge.t.push_back(node.t), edge.points.push_back(node.point);
  edge.points.front() = first, edge.points.back() = last;
}

// The ends of facets on edges, inside of the balls and of the edge.
std::map<std::uint32_t, std::vector<Node>> find_nodes(const Tessellation& face, const KeptFacets& facets) {
  std::map<std::uint32_t, std::vector<Node>> nodes;
  for (std::size_t i = 0; i < face.points.size(); ++i)
    if (face.classification[i].dim == 1 && facets.holds(face.points[i]))
      nodes[face.classification[i].index].push_back({face.edge_parameter[i], face.points[i], true});
  return nodes;
}

}  // namespace

bool KeptFacets::add(const KeptPlace& place) {
  const bool is_known = std::ranges::any_of(places_, [&](const KeptPlace& known) {
    return known.radius >= place.radius && distance(known.center, place.center) <= 0.5 * known.radius;
  });
  if (!is_known) places_.push_back(place);
  return !is_known;
}

bool KeptFacets::holds(const Vec3& x) const {
  return std::ranges::any_of(places_,
                             [&](const KeptPlace& place) { return distance(place.center, x) <= place.radius; });
}

void KeptFacets::put_on_edges(const GeometricModel& model, std::vector<EdgeMesh>& edges) const {
  if (empty()) return;
  const ModelTopology& topology = model.topology();
  std::vector<char> is_done(edges.size(), 0);
  for (std::size_t f = 0; f < topology.face_count(); ++f) {
    std::vector<std::uint32_t> near;
    for (const ModelLoop& loop : topology.face_to_loops[f])
      for (const EdgeUse& use : loop)
        if (!std::exchange(is_done[use.edge.value], 1) && !edges[use.edge.value].joined_to.valid() &&
            reaches(edges[use.edge.value], places_))
          near.push_back(use.edge.value);
    if (near.empty()) continue;
    const auto geometry = model.face_geometry(ModelFaceId(f));
    if (geometry->parametrization() != Parametrization::Piecewise) continue;
    const auto nodes = find_nodes(geometry->tessellate(0, 0), *this);
    for (const std::uint32_t e : near)
      if (const auto kept = nodes.find(e); kept != nodes.end()) put_nodes(kept->second, *this, edges[e]);
  }
}

}  // namespace tetloom
