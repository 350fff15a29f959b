#include "mesher/surface/face_rim.hpp"

#include <algorithm>
#include <unordered_map>
#include <unordered_set>

namespace tetloom {
namespace {

struct TracedPoint {
  std::uint32_t node;
  Vec2 uv;
  ModelEdgeId edge;  // of the segment that starts here
};

std::vector<TracedPoint> trace_use(const ModelTopology& topology, const EdgeUse& use, FaceGeometry& geometry,
                                   const RimNodes& rim) {
  const EdgeMesh& mesh = rim.mesh(use.edge);
  const bool degenerate = topology.edges[use.edge.value].degenerate;
  const ParameterRange range = degenerate ? geometry.edge_range(use) : ParameterRange{};
  std::vector<TracedPoint> points;
  for (std::size_t i = 0; i < mesh.t.size(); ++i) {
    const std::size_t k = use.forward ? i : mesh.t.size() - 1 - i;
    const double t = !degenerate ? mesh.t[k] : k == 0 ? range.lo : range.hi;
    points.push_back({rim.node(use.edge, k), geometry.edge_parameters(use, t), use.edge});
  }
  return points;
}

class RimTracer {
 public:
  RimTracer(const ModelTopology& topology, FaceGeometry& geometry, const RimNodes& rim)
      : topology_(topology), geometry_(geometry), rim_(rim) {}

  FaceRim run(ModelFaceId face) {
    const ParameterBox box = geometry_.parameter_box();
    tolerance_ = 1e-9 * (box.hi - box.lo);
    jump_ = kJump * (box.hi - box.lo);
    for (const ModelLoop& loop : topology_.face_to_loops[face.value])
      for (const EdgeUse& use : loop)
        if (topology_.edges[use.edge.value].degenerate)
          for (const ModelVertexId pole : topology_.edges[use.edge.value].vertices) poles_.insert(pole.value);
    for (const ModelLoop& loop : topology_.face_to_loops[face.value]) trace_loop(loop);
    return std::move(result_);
  }

 private:
  // Places of one node that are farther apart than this share of the face are different: the two sides of a seam, or
  // the corners at an apex.
  static constexpr double kJump = 0.05;

  static bool is_within(const Vec2& gap, const Vec2& bound) {
    return std::abs(gap.u) <= bound.u && std::abs(gap.v) <= bound.v;
  }

  void trace_loop(const ModelLoop& loop) {
    std::vector<TracedPoint> chain;
    for (std::size_t k = 0; k < loop.size(); ++k) {
      std::vector<TracedPoint> use = trace_use(topology_, loop[k], geometry_, rim_);
      if (!chain.empty()) join(chain, use.front());
      chain.insert(chain.end(), use.begin(), use.end());
    }
    if (chain.size() < 2) return;
    join(chain, chain.front());
    pull_to_vertices(chain);
    std::vector<std::uint32_t> ids;
    for (const TracedPoint& point : chain) ids.push_back(vertex(point));
    for (std::size_t i = 0; i < ids.size(); ++i) {
      const std::uint32_t next = ids[(i + 1) % ids.size()];
      if (ids[i] == next) continue;
      result_.segments.push_back({ids[i], next});
      result_.segment_to_edge.push_back(chain[i].edge);
    }
  }

  // The chain ends where the next use starts. Where the two parameter curves meet, one point serves both; where they
  // do not (an apex without a degenerate edge), both stay, as two places of one node.
  void join(std::vector<TracedPoint>& chain, const TracedPoint& start) {
    const TracedPoint& end = chain.back();
    if (end.node != start.node) return;
    if (is_within(start.uv - end.uv, jump_)) chain.pop_back();
  }

  // A parameter curve may end far from its vertex, as far as the vertex' tolerance allows. Where that is not small
  // against the pieces there, the vertex is placed where it lies, or the triangles at it would fold.
  void pull_to_vertices(std::vector<TracedPoint>& chain) const {
    constexpr double kNoticeable = 0.05;
    for (std::size_t i = 0; i < chain.size(); ++i) {
      if (chain[i].node >= topology_.vertex_count) continue;
      const Vec3& point = rim_.point(chain[i].node);
      const double before = distance(point, rim_.point(chain[(i + chain.size() - 1) % chain.size()].node));
      const double after = distance(point, rim_.point(chain[(i + 1) % chain.size()].node));
      const double gap = distance(point, geometry_.evaluate(chain[i].uv));
      if (gap <= kNoticeable * std::max(before, after)) continue;
      const SurfacePoint nearest = geometry_.closest_point(point, chain[i].uv);
      if (nearest.distance < 0.5 * gap) chain[i].uv = nearest.uv;
    }
  }

  // Loops may touch at a model vertex while their parameter curves end beside each other, as far apart as the vertex'
  // tolerance allows. With a place for each they would cross there however fine the edges are, so they share one. At a
  // pole nearby places are different corners.
  std::uint32_t vertex(const TracedPoint& point) {
    const bool is_regular_vertex = point.node < topology_.vertex_count && !poles_.contains(point.node);
    const Vec2 apart = is_regular_vertex ? jump_ : tolerance_;
    auto& places = by_node_[point.node];
    for (const std::uint32_t v : places)
      if (is_within(result_.vertices[v].uv - point.uv, apart)) return v;
    if (!places.empty()) result_.repeats_nodes = true;
    places.push_back(static_cast<std::uint32_t>(result_.vertices.size()));
    result_.vertices.push_back({point.node, point.uv});
    return places.back();
  }

  const ModelTopology& topology_;
  FaceGeometry& geometry_;
  const RimNodes& rim_;
  Vec2 tolerance_, jump_;
  std::unordered_set<std::uint32_t> poles_;  // model vertices; looked up only
  FaceRim result_;
  std::unordered_map<std::uint32_t, std::vector<std::uint32_t>> by_node_;  // looked up only
};

}  // namespace

FaceRim trace_rim(const ModelTopology& topology, ModelFaceId face, FaceGeometry& geometry, const RimNodes& rim) {
  return RimTracer(topology, geometry, rim).run(face);
}

}  // namespace tetloom
