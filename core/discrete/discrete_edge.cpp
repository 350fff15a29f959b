#include "core/discrete/discrete_edge.hpp"
#include "core/spatial/distances.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace tetloom::detail {
namespace {

/// 1 / radius of the circle through three points.
double circle_curvature(const Vec3& a, const Vec3& b, const Vec3& c) {
  const double product = distance(a, b) * distance(b, c) * distance(c, a);
  return product > 0 ? 2 * norm(cross(b - a, c - a)) / product : 0;
}

}  // namespace

DiscreteEdge::DiscreteEdge(std::shared_ptr<const Polyline> line) : held_(std::move(line)), line_(*held_) {
  box_pieces();
}

void DiscreteEdge::box_pieces() {
  for (std::size_t begin = 0; begin < piece_count(); begin += kPiecesPerBox) {
    Box3 box;
    for (std::size_t i = begin; i <= std::min(begin + kPiecesPerBox, piece_count()); ++i) box.add(line_.points[i]);
    boxes_.push_back(box);
  }
}

double DiscreteEdge::normalize(double t) const {
  if (line_.closed && (t < 0 || t > length())) {
    t = std::fmod(t, length());
    if (t < 0) t += length();
  }
  return std::clamp(t, 0.0, length());
}

std::size_t DiscreteEdge::find_piece(double t) const {
  const auto after = std::upper_bound(line_.lengths.begin(), line_.lengths.end(), t);
  const auto index = static_cast<std::size_t>(after - line_.lengths.begin());
  return std::min(std::max<std::size_t>(index, 1) - 1, piece_count() - 1);
}

Vec3 DiscreteEdge::evaluate(double t) {
  t = normalize(t);
  const std::size_t i = find_piece(t);
  const double begin = line_.lengths[i], end = line_.lengths[i + 1];
  if (t >= end) return line_.points[i + 1];
  return line_.points[i] + (t - begin) / (end - begin) * (line_.points[i + 1] - line_.points[i]);
}

Vec3 DiscreteEdge::derivative(double t) {
  const std::size_t i = find_piece(normalize(t));
  return normalized(line_.points[i + 1] - line_.points[i]);
}

double DiscreteEdge::curvature_at(std::size_t point) const {
  const std::size_t last = piece_count();
  if (last < 2) return 0;
  const auto inner = [&](std::size_t i) {
    return circle_curvature(line_.points[i - 1], line_.points[i], line_.points[i + 1]);
  };
  if (point > 0 && point < last) return inner(point);
  if (!line_.closed) return inner(point == 0 ? 1 : last - 1);
  // A closed edge may have a corner at its vertex, which is no curvature.
  const double across = circle_curvature(line_.points[last - 1], line_.points[0], line_.points[1]);
  return std::min(across, std::max(inner(1), inner(last - 1)));
}

double DiscreteEdge::curvature(double t) {
  t = normalize(t);
  const std::size_t i = find_piece(t);
  const double s = (t - line_.lengths[i]) / (line_.lengths[i + 1] - line_.lengths[i]);
  return (1 - s) * curvature_at(i) + s * curvature_at(i + 1);
}

CurvePoint DiscreteEdge::closest_point(const Vec3& x) {
  std::size_t best_piece = 0;
  double best_share = 0, best = HUGE_VAL;
  for (std::size_t box = 0; box < boxes_.size(); ++box) {
    if (!(squared_distance_to_box(x, boxes_[box]) < best)) continue;
    const std::size_t begin = box * kPiecesPerBox, end = std::min(begin + kPiecesPerBox, piece_count());
    for (std::size_t i = begin; i < end; ++i) {
      const Vec3 a = line_.points[i], d = line_.points[i + 1] - a;
      const double share = std::clamp(dot(x - a, d) / norm2(d), 0.0, 1.0);
      const double distance2 = norm2(a + share * d - x);
      if (distance2 < best) best = distance2, best_piece = i, best_share = share;
    }
  }
  const double begin = line_.lengths[best_piece], end = line_.lengths[best_piece + 1];
  CurvePoint result;
  result.t = best_share < 1 ? begin + best_share * (end - begin) : end;
  result.point = evaluate(result.t);
  result.distance = distance(result.point, x);
  return result;
}

}  // namespace tetloom::detail
