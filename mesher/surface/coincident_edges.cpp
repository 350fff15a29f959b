#include "mesher/surface/coincident_edges.hpp"

#include <algorithm>
#include <map>
#include <span>

namespace tetloom {
namespace {

constexpr int kSamples = 8;
/// Of the length of edges of one piece: what they part by is far below what the piece resolves.
constexpr double kLoneShare = 1e-3;

Vec3 point_at(EdgeGeometry& edge, double share) {
  const ParameterRange range = edge.range();
  return edge.evaluate(range.lo + share * (range.hi - range.lo));
}

double length_of(EdgeGeometry& edge) {
  double length = 0;
  for (int i = 0; i < kSamples; ++i)
    length += distance(point_at(edge, i / double{kSamples}), point_at(edge, (i + 1) / double{kSamples}));
  return length;
}

/// The largest distance of samples of `a` from `b`, or something larger than `bound`.
double deviation(EdgeGeometry& a, EdgeGeometry& b, double bound) {
  double largest = 0;
  for (const int i : {4, 2, 6, 1, 7, 3, 5}) {
    largest = std::max(largest, b.closest_point(point_at(a, i / double{kSamples})).distance);
    if (largest > bound) break;
  }
  return largest;
}

class CoincidenceFinder {
 public:
  CoincidenceFinder(const GeometricModel& model, const std::vector<bool>& lone)
      : model_(model), edges_(model.topology().edges), lone_(lone) {}

  std::vector<JoinedEdge> run() {
    std::vector<JoinedEdge> joined;
    std::map<std::array<ModelVertexId, 2>, std::vector<ModelEdgeId>> by_ends;
    for (std::uint32_t e = 0; e < edges_.size(); ++e) {
      joined.push_back({ModelEdgeId(e), false});
      if (edges_[e].degenerate) continue;
      auto ends = edges_[e].vertices;
      if (ends[1] < ends[0]) std::swap(ends[0], ends[1]);
      by_ends[ends].push_back(ModelEdgeId(e));
    }
    for (const auto& [ends, group] : by_ends)
      for (std::size_t i = 1; i < group.size(); ++i) joined[group[i].value] = find(group[i], {group.data(), i}, joined);
    return joined;
  }

 private:
  JoinedEdge find(ModelEdgeId edge, std::span<const ModelEdgeId> earlier, const std::vector<JoinedEdge>& joined) const {
    for (const ModelEdgeId other : earlier)
      if (joined[other.value].to == other && coincide(edge, other)) return {other, run_apart(edge, other)};
    return {edge, false};
  }

  bool coincide(ModelEdgeId a, ModelEdgeId b) const {
    const auto first = model_.edge_geometry(a), second = model_.edge_geometry(b);
    double bound = std::max(model_.attributes(a).tolerance, model_.attributes(b).tolerance);
    if (lone_[a.value] && lone_[b.value])
      bound = std::max(bound, kLoneShare * std::min(length_of(*first), length_of(*second)));
    return deviation(*first, *second, bound) <= bound && deviation(*second, *first, bound) <= bound;
  }

  bool run_apart(ModelEdgeId a, ModelEdgeId b) const {
    const auto& of_a = edges_[a.value].vertices;
    const auto& of_b = edges_[b.value].vertices;
    if (of_a[0] != of_a[1]) return of_a[0] != of_b[0];
    const auto first = model_.edge_geometry(a), second = model_.edge_geometry(b);
    const auto along = [&](double share) { return second->closest_point(point_at(*first, share)).t; };
    return along(0.75) < along(0.25);
  }

  const GeometricModel& model_;
  const std::vector<ModelEdgeTopology>& edges_;
  const std::vector<bool>& lone_;
};

}  // namespace

std::vector<JoinedEdge> find_coincident_edges(const GeometricModel& model, const std::vector<bool>& lone) {
  return CoincidenceFinder(model, lone).run();
}

}  // namespace tetloom
