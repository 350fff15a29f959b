#include "mesher/surface/face_plane.hpp"

#include <algorithm>
#include <cmath>
#include <map>

namespace tetloom {
namespace {

/// The nodes of the piece `i` of an edge use, in the direction of the loop.
std::array<std::uint32_t, 2> piece_of(const EdgeUse& use, std::size_t i, const RimNodes& rim) {
  const std::array nodes{rim.node(use.edge, i), rim.node(use.edge, i + 1)};
  return use.forward ? nodes : std::array{nodes[1], nodes[0]};
}

template <class Visit>
void for_each_piece(const ModelTopology& topology, ModelFaceId face, const RimNodes& rim, const Visit& visit) {
  for (const ModelLoop& loop : topology.face_to_loops[face.value])
    for (const EdgeUse& use : loop) {
      if (topology.edges[use.edge.value].degenerate) continue;
      for (std::size_t i = 0; i + 1 < rim.mesh(use.edge).points.size(); ++i) visit(use.edge, piece_of(use, i, rim));
    }
}

using NodePair = std::array<std::uint32_t, 2>;

NodePair sorted(const NodePair& piece) { return {std::min(piece[0], piece[1]), std::max(piece[0], piece[1])}; }

/// For the two nodes of every piece how often it is run through forward, less how often backward.
std::map<NodePair, int> count_uses(const ModelTopology& topology, ModelFaceId face, const RimNodes& rim) {
  std::map<NodePair, int> uses;
  for_each_piece(topology, face, rim,
                 [&](ModelEdgeId, const NodePair& piece) { uses[sorted(piece)] += piece[0] < piece[1] ? 1 : -1; });
  return uses;
}

}  // namespace

std::optional<double> length_of_cancelled_rim(const ModelTopology& topology, ModelFaceId face, const RimNodes& rim) {
  double length = 0;
  for (const auto& [piece, count] : count_uses(topology, face, rim)) {
    if (count != 0) return {};
    length += 2 * distance(rim.point(piece[0]), rim.point(piece[1]));
  }
  return length;
}

std::optional<FittedPlane> fit_plane(const ModelTopology& topology, ModelFaceId face, const RimNodes& rim) {
  Vec3 sum;
  double length = 0;
  for_each_piece(topology, face, rim, [&](ModelEdgeId, const std::array<std::uint32_t, 2>& piece) {
    const Vec3 &a = rim.point(piece[0]), &b = rim.point(piece[1]);
    sum += 0.5 * distance(a, b) * (a + b);
    length += distance(a, b);
  });
  if (!(length > 0)) return {};
  FittedPlane plane;
  plane.origin = sum / length;
  Vec3 area;
  for_each_piece(topology, face, rim, [&](ModelEdgeId, const std::array<std::uint32_t, 2>& piece) {
    area += 0.5 * cross(rim.point(piece[0]) - plane.origin, rim.point(piece[1]) - plane.origin);
  });
  constexpr double kLeastArea = 1e-12;  // of the squared length of the rim
  if (!(norm(area) > kLeastArea * length * length)) return {};
  plane.normal = normalized(area);
  const Vec3& n = plane.normal;
  const Vec3 axis = std::abs(n.x) < 0.6 ? Vec3{1, 0, 0} : std::abs(n.y) < 0.6 ? Vec3{0, 1, 0} : Vec3{0, 0, 1};
  plane.first = normalized(cross(axis, n));
  plane.second = cross(n, plane.first);
  return plane;
}

FaceRim trace_rim(const ModelTopology& topology, ModelFaceId face, const FittedPlane& plane, const RimNodes& rim) {
  std::map<NodePair, int> uses = count_uses(topology, face, rim);
  FaceRim result;
  std::map<std::uint32_t, std::uint32_t> numbers;
  const auto vertex = [&](std::uint32_t node) {
    const auto [place, is_new] = numbers.try_emplace(node, static_cast<std::uint32_t>(result.vertices.size()));
    if (is_new) result.vertices.push_back({node, plane.to_plane(rim.point(node))});
    return place->second;
  };
  for_each_piece(topology, face, rim, [&](ModelEdgeId edge, const auto& piece) {
    if (piece[0] == piece[1] || uses[sorted(piece)] == 0) return;
    result.segments.push_back({vertex(piece[0]), vertex(piece[1])});
    result.segment_to_edge.push_back(edge);
  });
  return result;
}

FaceOverPlane::FaceOverPlane(FaceGeometry& face, const FittedPlane& plane, const FaceRim& rim,
                             std::span<const Vec3> nodes, bool follow)
    : face_(face), plane_(plane), box_{{HUGE_VAL, HUGE_VAL}, {-HUGE_VAL, -HUGE_VAL}}, follow_(follow) {
  std::vector<RimPoint> points;
  for (const FaceRim::Vertex& vertex : rim.vertices) {
    points.push_back({vertex.uv, dot(nodes[vertex.node] - plane.origin, plane.normal)});
    box_.lo = {std::min(box_.lo.u, vertex.uv.u), std::min(box_.lo.v, vertex.uv.v)};
    box_.hi = {std::max(box_.hi.u, vertex.uv.u), std::max(box_.hi.v, vertex.uv.v)};
  }
  for (const auto& [start, end] : rim.segments) rim_.push_back({points[start], points[end]});
  reach_ = norm(box_.hi - box_.lo);
}

FaceOverPlane::RimHeight FaceOverPlane::rim_height(const Vec2& uv) const {
  const double touching = 1e-9 * reach_;
  double weights = 0, sum = 0, nearest = HUGE_VAL;
  for (const auto& [start, end] : rim_) {
    const Vec2 a = start.place - uv, b = end.place - uv;
    const double to_a = norm(a), to_b = norm(b), area = cross(a, b), along = dot(a, b);
    if (to_a <= touching) return {start.height, to_a};
    nearest = std::min(nearest, to_a);
    const bool between = along < 0 && std::abs(area) <= touching * norm(b - a);
    if (between) return {(to_b * start.height + to_a * end.height) / (to_a + to_b), std::min(to_a, to_b)};
    const double half_tangent = area / (to_a * to_b + along);
    weights += half_tangent * (1 / to_a + 1 / to_b);
    sum += half_tangent * (start.height / to_a + end.height / to_b);
  }
  return {sum / weights, nearest};
}

// Between the rim, without the surface; the slope by differences.
SurfaceDerivatives FaceOverPlane::spanned_at(const Vec2& uv, double height) const {
  const double step = 1e-5 * reach_;
  const auto slope = [&](const Vec2& aside) {
    const double rise = (rim_height(uv + aside).height - rim_height(uv - aside).height) / (2 * step);
    return std::isfinite(rise) ? rise : 0;
  };
  return {plane_.origin + uv.u * plane_.first + uv.v * plane_.second + height * plane_.normal,
          plane_.first + slope({step, 0}) * plane_.normal, plane_.second + slope({0, step}) * plane_.normal};
}

// The foot of the closest point moves along the normal until it stands over the point of the plane.
std::optional<SurfaceDerivatives> FaceOverPlane::surface_above(const Vec3& base) {
  constexpr int kSteps = 12;
  constexpr double kExact = 1e-7, kSteepest = 0.1;  // of the reach; cosine
  double height = 0;
  for (int step = 0; step < kSteps; ++step) {
    const SurfacePoint found = face_.closest_point(base + height * plane_.normal, guess_);
    const double next = dot(found.point - base, plane_.normal);
    const Vec3 aside = found.point - base - next * plane_.normal;
    if (!(norm(aside) <= reach_) || !(std::abs(next) <= reach_)) return {};
    guess_ = found.uv;
    const bool settled = std::abs(next - height) <= kExact * reach_;
    height = next;
    if (!settled) continue;
    const Vec3 normal = face_.normal(found.uv);
    const double upright = dot(normal, plane_.normal);
    if (!(std::abs(upright) > kSteepest)) return {};
    const auto along = [&](const Vec3& axis) { return axis - (dot(normal, axis) / upright) * plane_.normal; };
    return SurfaceDerivatives{base + height * plane_.normal, along(plane_.first), along(plane_.second)};
  }
  return {};
}

SurfaceDerivatives FaceOverPlane::derivatives(const Vec2& uv) {
  const RimHeight rim = rim_height(uv);
  const double height = std::isfinite(rim.height) ? rim.height : 0;
  if (!follow_) return spanned_at(uv, height);
  const Vec3 base = plane_.origin + uv.u * plane_.first + uv.v * plane_.second + height * plane_.normal;
  constexpr double kCliff = 2;
  if (const auto found = surface_above(base))
    if (std::abs(dot(found->point - base, plane_.normal)) <= kCliff * rim.distance) return *found;
  return spanned_at(uv, height);
}

Vec3 FaceOverPlane::normal(const Vec2& uv) {
  const SurfaceDerivatives d = derivatives(uv);
  return normalized(cross(d.du, d.dv));
}

SurfacePoint FaceOverPlane::closest_point(const Vec3& x, const std::optional<Vec2>&) {
  const Vec2 uv = plane_.to_plane(x);
  const Vec3 point = evaluate(uv);
  return {uv, point, distance(x, point)};
}

}  // namespace tetloom
