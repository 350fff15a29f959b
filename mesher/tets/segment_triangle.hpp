#pragma once
// Whether a closed segment and a closed triangle meet where a simplicial complex would not let them.
#include <array>
#include <cstdint>
#include <utility>

#include "core/predicates/predicates.hpp"
#include "core/spatial/along_axis.hpp"

namespace tetloom::tets {

/// The turn of three points in a plane of space, 1 when they turn as the given triangle does. Exact.
class PlaneTurn {
 public:
  /// Pre: a, b, c are not collinear.
  PlaneTurn(const Vec3& a, const Vec3& b, const Vec3& c) {
    const Vec3 normal = cross(b - a, c - a);
    const double size = norm(b - a) + norm(c - a);
    // Any point off the plane shows the turns; rounding may spoil the direction, so that all three are tried.
    for (int i = 0; i < 3 && sign_ == 0; ++i) {
      off_ = a;
      off_[(nearest_axis(normal) + i) % 3] += size;
      sign_ = orient3d(a, b, c, off_);
    }
  }
  int operator()(const Vec3& p, const Vec3& q, const Vec3& r) const { return sign_ * orient3d(p, q, r, off_); }

 private:
  Vec3 off_;
  int sign_ = 0;
};

namespace detail {

template <class PointOf>
bool segment_meets_in_plane(const PointOf& point, std::uint32_t p, std::uint32_t q,
                            const std::array<std::uint32_t, 3>& t) {
  const PlaneTurn turn(point(t[0]), point(t[1]), point(t[2]));
  // Separated by a line of the triangle or by the segment's own: the separating axes of two convex sets in a plane.
  // A segment on a line of the triangle is compared by the other two lines.
  for (int i = 0; i < 3; ++i) {
    if (turn(point(t[i]), point(t[(i + 1) % 3]), point(p)) < 0 &&
        turn(point(t[i]), point(t[(i + 1) % 3]), point(q)) < 0)
      return false;
  }
  int left = 0, right = 0;
  for (int i = 0; i < 3; ++i) {
    const int side = turn(point(p), point(q), point(t[i]));
    left += side > 0;
    right += side < 0;
  }
  return left < 3 && right < 3;
}

}  // namespace detail

/// False when all that the segment pq and the triangle t have in common is a vertex or edge of both. Exact.
/// `sign(i, j, k, l)` is orient3d of the points with these ids, `point(i)` the point. Pre: t is not degenerate.
template <class Sign, class PointOf>
bool segment_meets_triangle(const Sign& sign, const PointOf& point, std::uint32_t p, std::uint32_t q,
                            std::array<std::uint32_t, 3> t) {
  int at_p = -1, at_q = -1;
  for (int i = 0; i < 3; ++i) {
    if (t[i] == p) at_p = i;
    if (t[i] == q) at_q = i;
  }
  if (at_p >= 0 && at_q >= 0) return false;
  if (at_p >= 0 || at_q >= 0) {
    const std::uint32_t end = at_p >= 0 ? q : p;
    const int at = at_p >= 0 ? at_p : at_q;
    const std::uint32_t a = t[at], b = t[(at + 1) % 3], c = t[(at + 2) % 3];
    if (sign(a, b, c, end) != 0) return false;
    const PlaneTurn turn(point(a), point(b), point(c));
    return turn(point(a), point(b), point(end)) >= 0 && turn(point(a), point(end), point(c)) >= 0;
  }
  const int side_p = sign(t[0], t[1], t[2], p), side_q = sign(t[0], t[1], t[2], q);
  if (side_p == side_q) return side_p == 0 && detail::segment_meets_in_plane(point, p, q, t);
  const int u = sign(p, q, t[0], t[1]), v = sign(p, q, t[1], t[2]), w = sign(p, q, t[2], t[0]);
  return (u >= 0 && v >= 0 && w >= 0) || (u <= 0 && v <= 0 && w <= 0);
}

}  // namespace tetloom::tets
