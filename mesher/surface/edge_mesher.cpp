#include "mesher/surface/edge_mesher.hpp"

#include <algorithm>
#include <map>
#include <numbers>

#include "mesher/surface/coincident_edges.hpp"
#include "tetloom/assert.hpp"
#include "tetloom/tasks.hpp"

namespace tetloom {
namespace {

/// ∫ ds/h along an edge as a table: `count[i]` pieces of size h fit between the start and `t[i]`.
struct SizeIntegral {
  std::vector<double> t, count;
  double turning = 0;  ///< radians that the tangent turns by along the edge
  double length = 0;
  double sag = 0;  ///< largest distance from the chord of the whole edge
};

class EdgeIntegrator {
 public:
  EdgeIntegrator(EdgeGeometry& edge, const SizeField& sizes) : edge_(edge), sizes_(sizes) {}

  SizeIntegral run() {
    const ParameterRange range = edge_.range();
    constexpr int kPieces = 16;
    Sample left = sample(range.lo);
    first_ = left.point;
    chord_ = edge_.evaluate(range.hi) - first_;
    previous_tangent_ = left.tangent;
    result_.t.push_back(range.lo);
    result_.count.push_back(0);
    for (int i = 1; i <= kPieces; ++i) {
      const Sample right = sample(range.lo + (range.hi - range.lo) * i / kPieces);
      refine(left, right, 0);
      left = right;
    }
    return std::move(result_);
  }

 private:
  struct Sample {
    double t, speed, density;  // |dX/dt| and |dX/dt| / h
    Vec3 point, tangent;
  };

  Sample sample(double t) {
    const Vec3 point = edge_.evaluate(t), derivative = edge_.derivative(t);
    const double speed = norm(derivative);
    return {t, speed, speed / sizes_.size_at(point), point, normalized(derivative)};
  }

  void refine(const Sample& a, const Sample& b, int depth) {
    const Sample m = sample(0.5 * (a.t + b.t));
    const double width = b.t - a.t;
    const double trapezoid = 0.5 * (a.density + b.density) * width;
    const double simpson = (a.density + 4 * m.density + b.density) * width / 6;
    constexpr int kDeepest = 24;
    const bool long_piece = simpson > 2, inexact = std::abs(simpson - trapezoid) > 0.01 * simpson + 1e-4;
    if ((long_piece || inexact) && depth < kDeepest) {
      refine(a, m, depth + 1);
      refine(m, b, depth + 1);
      return;
    }
    append(m, simpson / 2);
    append(b, simpson / 2);
    result_.length += (a.speed + 4 * m.speed + b.speed) * width / 6;
  }

  void append(const Sample& s, double pieces) {
    result_.t.push_back(s.t);
    result_.count.push_back(result_.count.back() + pieces);
    const double turn = std::acos(std::clamp(dot(previous_tangent_, s.tangent), -1.0, 1.0));
    if (norm2(s.tangent) > 0 && norm2(previous_tangent_) > 0) result_.turning += turn;
    previous_tangent_ = s.tangent;
    const Vec3 offset = s.point - first_;
    const double along = norm2(chord_) > 0 ? std::clamp(dot(offset, chord_) / norm2(chord_), 0.0, 1.0) : 0;
    result_.sag = std::max(result_.sag, norm(offset - along * chord_));
  }

  EdgeGeometry& edge_;
  const SizeField& sizes_;
  SizeIntegral result_;
  Vec3 first_, chord_, previous_tangent_;
};

double parameter_at(const SizeIntegral& integral, double count) {
  const auto above = std::upper_bound(integral.count.begin(), integral.count.end(), count);
  if (above == integral.count.begin()) return integral.t.front();
  if (above == integral.count.end()) return integral.t.back();
  const auto i = static_cast<std::size_t>(above - integral.count.begin());
  const double share = (count - integral.count[i - 1]) / (integral.count[i] - integral.count[i - 1]);
  return integral.t[i - 1] + share * (integral.t[i] - integral.t[i - 1]);
}

std::size_t piece_count(const SizeIntegral& integral, bool closed, double finer) {
  constexpr double kLargestTurn = 80 * std::numbers::pi / 180;
  // Rounding that makes the mean piece as near to the size as a whole number allows, on either side.
  const double wanted = integral.count.back() * finer;
  const double lower = std::max(1.0, std::floor(wanted));
  const double best = wanted / lower > (lower + 1) / std::max(wanted, 1e-300) ? lower + 1 : lower;
  const double turns = std::ceil(integral.turning / kLargestTurn - 1e-6);
  return static_cast<std::size_t>(std::max({best, turns, closed ? 3.0 : 1.0}));
}

EdgeMesh place_nodes(EdgeGeometry& edge, const SizeIntegral& integral, std::size_t pieces, const Vec3& start,
                     const Vec3& end) {
  EdgeMesh mesh;
  mesh.t.reserve(pieces + 1);
  mesh.points.reserve(pieces + 1);
  mesh.t.push_back(integral.t.front());
  mesh.points.push_back(start);
  for (std::size_t i = 1; i < pieces; ++i) {
    const double share = static_cast<double>(i) / static_cast<double>(pieces);
    mesh.t.push_back(parameter_at(integral, share * integral.count.back()));
    mesh.points.push_back(edge.evaluate(mesh.t.back()));
  }
  mesh.t.push_back(integral.t.back());
  mesh.points.push_back(end);
  return mesh;
}

struct MeasuredEdge {
  SizeIntegral integral;
  std::size_t pieces = 1;
};

// Edges on each other get as many pieces as the one that asks for most.
std::vector<JoinedEdge> join_coincident_edges(const GeometricModel& model, std::vector<MeasuredEdge>& edges) {
  std::vector<bool> lone;
  for (const MeasuredEdge& edge : edges) lone.push_back(edge.pieces == 1);
  const std::vector<JoinedEdge> joined = find_coincident_edges(model, lone);
  for (std::size_t e = 0; e < edges.size(); ++e) {
    std::size_t& pieces = edges[joined[e].to.value].pieces;
    pieces = std::max(pieces, edges[e].pieces);
  }
  return joined;
}

// The nodes of another edge as those of this one.
EdgeMesh share_nodes(EdgeGeometry& edge, const EdgeMesh& shared, const JoinedEdge& joined) {
  EdgeMesh mesh{shared.t, shared.points, joined.to, joined.reversed};
  if (joined.reversed) std::reverse(mesh.points.begin(), mesh.points.end());
  const ParameterRange range = edge.range();
  const std::size_t last = mesh.t.size() - 1;
  mesh.t.front() = range.lo;
  mesh.t.back() = range.hi;
  for (std::size_t i = 1; i < last; ++i)
    mesh.t[i] = std::clamp(edge.closest_point(mesh.points[i]).t, mesh.t[i - 1], range.hi);
  return mesh;
}

// Curved edges of one piece that share both ends with another edge of one piece get a second piece.
void separate_parallel_edges(const ModelTopology& topology, const std::vector<JoinedEdge>& joined,
                             std::vector<MeasuredEdge>& edges) {
  std::map<std::array<ModelVertexId, 2>, std::vector<std::size_t>> by_ends;
  for (std::size_t e = 0; e < edges.size(); ++e) {
    if (topology.edges[e].degenerate || edges[e].pieces != 1 || joined[e].to.value != e) continue;
    auto ends = topology.edges[e].vertices;
    if (ends[1] < ends[0]) std::swap(ends[0], ends[1]);
    by_ends[ends].push_back(e);
  }
  for (const auto& [ends, group] : by_ends) {
    if (group.size() < 2) continue;
    const auto straightest = *std::min_element(group.begin(), group.end(), [&](std::size_t a, std::size_t b) {
      return edges[a].integral.sag < edges[b].integral.sag;
    });
    for (const std::size_t e : group)
      if (e != straightest) edges[e].pieces = 2;
  }
}

// A loop that runs along one edge and back, as around a crease that ends within its face, has two pieces each way: one
// would leave it two nodes.
void open_slits(const ModelTopology& topology, std::vector<MeasuredEdge>& edges) {
  for (const std::vector<ModelLoop>& loops : topology.face_to_loops)
    for (const ModelLoop& loop : loops) {
      if (loop.size() != 2 || loop[0].edge != loop[1].edge) continue;
      std::size_t& pieces = edges[loop[0].edge.value].pieces;
      pieces = std::max<std::size_t>(pieces, 2);
    }
}

}  // namespace

std::vector<EdgeMesh> mesh_edges(const GeometricModel& model, const SizeField& sizes, const EdgeMeshOptions& options,
                                 const TaskRunner& runner) {
  const ModelTopology& topology = model.topology();
  const std::size_t count = topology.edge_count();
  TETLOOM_ASSERT(options.finer.empty() || options.finer.size() == count);
  std::vector<MeasuredEdge> measured(count);
  std::vector<EdgeMesh> meshes(count);
  std::vector<JoinedEdge> joined;
  const auto measure = [&](std::size_t e) {
    if (topology.edges[e].degenerate) return;
    const auto edge = model.edge_geometry(ModelEdgeId(e));
    measured[e].integral = EdgeIntegrator(*edge, sizes).run();
    const bool closed = topology.edges[e].vertices[0] == topology.edges[e].vertices[1];
    const double finer = options.finer.empty() ? 1 : options.finer[e];
    if (!std::isfinite(measured[e].integral.count.back()))
      throw Error({ErrorCode::EdgeFailed,
                   "the edge cannot be evaluated",
                   {model.named(ModelEdgeId(e))},
                   model.vertex_point(topology.edges[e].vertices[0]),
                   {}});
    measured[e].pieces = piece_count(measured[e].integral, closed, finer);
  };
  const auto place = [&](std::size_t e) {
    if (joined[e].to.value != e) return;
    const auto [start, end] = topology.edges[e].vertices;
    const Vec3 first = model.vertex_point(start), last = model.vertex_point(end);
    if (topology.edges[e].degenerate) {
      meshes[e] = {{0, 1}, {first, last}, {}, false};
    } else {
      meshes[e] =
          place_nodes(*model.edge_geometry(ModelEdgeId(e)), measured[e].integral, measured[e].pieces, first, last);
    }
    runner.advance(1, ModelEdgeId(e));
  };
  runner.begin_stage(Stage::Edges, count);
  runner.for_each(count, measure);
  joined = join_coincident_edges(model, measured);
  separate_parallel_edges(topology, joined, measured);
  open_slits(topology, measured);
  runner.for_each(count, place);
  for (std::size_t e = 0; e < count; ++e) {
    if (joined[e].to.value == e) continue;
    meshes[e] = share_nodes(*model.edge_geometry(ModelEdgeId(e)), meshes[joined[e].to.value], joined[e]);
    runner.advance(1, ModelEdgeId(e));
  }
  return meshes;
}

}  // namespace tetloom
