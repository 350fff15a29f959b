#include "mesher/intersection/triangle_pair.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/predicates/predicates.hpp"
#include "core/spatial/along_axis.hpp"

namespace tetloom::intersection {

namespace {

using Corners = std::array<Vec3, 3>;

int side(const Vec3& a, const Vec3& b, const Vec3& x, int axis) {
  return orient2d(without_axis(a, axis), without_axis(b, axis), without_axis(x, axis));
}

// The coordinate along which the triangle looks largest; never one along which it vanishes.
int projection_axis(const Corners& t) {
  int axis = nearest_axis(cross(t[1] - t[0], t[2] - t[0]));
  for (int tries = 0; tries < 2 && side(t[0], t[1], t[2], axis) == 0; ++tries) axis = (axis + 1) % 3;
  return axis;
}

// Pre: x in the plane of t.
bool contains_in_plane(const Corners& t, const Vec3& x, int axis) {
  const int s0 = side(t[0], t[1], x, axis), s1 = side(t[1], t[2], x, axis), s2 = side(t[2], t[0], x, axis);
  return (s0 >= 0 && s1 >= 0 && s2 >= 0) || (s0 <= 0 && s1 <= 0 && s2 <= 0);
}

bool is_between(double x, double a, double b) { return std::min(a, b) <= x && x <= std::max(a, b); }

// Pre: x on the line through a and b in the projection.
bool on_segment(const Vec2& a, const Vec2& b, const Vec2& x) {
  return is_between(x.u, a.u, b.u) && is_between(x.v, a.v, b.v);
}

// Where two closed segments of one plane meet, if they do.
std::optional<Vec3> segments_meet(const Vec3& p, const Vec3& q, const Vec3& a, const Vec3& b, int axis) {
  const int sp = side(a, b, p, axis), sq = side(a, b, q, axis), sa = side(p, q, a, axis), sb = side(p, q, b, axis);
  if (sp * sq < 0 && sa * sb < 0) {
    const Vec2 u = without_axis(p, axis), d = without_axis(q, axis) - u,
               e = without_axis(b, axis) - without_axis(a, axis);
    const double t = cross(without_axis(a, axis) - u, e) / cross(d, e);
    return p + std::clamp(std::isfinite(t) ? t : 0.5, 0.0, 1.0) * (q - p);
  }
  const Vec2 p2 = without_axis(p, axis), q2 = without_axis(q, axis), a2 = without_axis(a, axis),
             b2 = without_axis(b, axis);
  if (sp == 0 && on_segment(a2, b2, p2)) return p;
  if (sq == 0 && on_segment(a2, b2, q2)) return q;
  if (sa == 0 && on_segment(p2, q2, a2)) return a;
  if (sb == 0 && on_segment(p2, q2, b2)) return b;
  return std::nullopt;
}

// Pre: p and q in the plane of t.
std::optional<Vec3> segment_meets_in_plane(const Vec3& p, const Vec3& q, const Corners& t, int axis) {
  if (contains_in_plane(t, p, axis)) return p;
  if (contains_in_plane(t, q, axis)) return q;
  for (int i = 0; i < 3; ++i) {
    if (auto point = segments_meet(p, q, t[i], t[(i + 1) % 3], axis)) return point;
  }
  return std::nullopt;
}

Vec3 point_in_plane(const Vec3& p, const Vec3& q, const Corners& t) {
  const Vec3 n = cross(t[1] - t[0], t[2] - t[0]);
  const double hp = dot(p - t[0], n), hq = dot(q - t[0], n);
  const double s = hp / (hp - hq);
  return p + std::clamp(std::isfinite(s) ? s : 0.5, 0.0, 1.0) * (q - p);
}

// Where the closed segment pq meets the closed triangle t; sp and sq are orient3d of t with p and q.
std::optional<Vec3> segment_meets(const Vec3& p, const Vec3& q, const std::pair<int, int>& signs, const Corners& t) {
  const auto [sp, sq] = signs;
  if (sp * sq > 0) return std::nullopt;
  if (sp == 0 && sq == 0) return segment_meets_in_plane(p, q, t, projection_axis(t));
  if (sp == 0) return contains_in_plane(t, p, projection_axis(t)) ? std::optional(p) : std::nullopt;
  if (sq == 0) return contains_in_plane(t, q, projection_axis(t)) ? std::optional(q) : std::nullopt;
  const int s0 = orient3d(p, q, t[0], t[1]), s1 = orient3d(p, q, t[1], t[2]), s2 = orient3d(p, q, t[2], t[0]);
  if ((s0 >= 0 && s1 >= 0 && s2 >= 0) || (s0 <= 0 && s1 <= 0 && s2 <= 0)) return point_in_plane(p, q, t);
  return std::nullopt;
}

bool all_on_one_side(const std::array<int, 3>& signs) {
  return (signs[0] > 0 && signs[1] > 0 && signs[2] > 0) || (signs[0] < 0 && signs[1] < 0 && signs[2] < 0);
}

std::array<int, 3> sides_of_plane(const Corners& plane, const Corners& t) {
  std::array<int, 3> signs{};
  for (int i = 0; i < 3; ++i) signs[i] = orient3d(plane[0], plane[1], plane[2], t[i]);
  return signs;
}

// The line of a side of `a` has `a` on one side and `b` on the other, in projection.
bool side_separates(const Corners& a, const Corners& b, int axis) {
  for (int i = 0; i < 3; ++i) {
    const Vec3 &from = a[i], &to = a[(i + 1) % 3];
    const int own = side(from, to, a[(i + 2) % 3], axis);
    if (own != 0 && std::all_of(b.begin(), b.end(), [&](const Vec3& x) { return side(from, to, x, axis) * own < 0; })) {
      return true;
    }
  }
  return false;
}

// No shared vertex. The test in projection comes first because in flat faces those in space are all nearly zero.
std::optional<PairVerdict> check_apart(const Corners& a, const Corners& b) {
  const int axis = projection_axis(a);
  if (side_separates(a, b, axis) || side_separates(b, a, axis)) return std::nullopt;
  const auto b_to_a = sides_of_plane(a, b);
  if (all_on_one_side(b_to_a)) return std::nullopt;
  const auto a_to_b = sides_of_plane(b, a);
  if (all_on_one_side(a_to_b)) return std::nullopt;
  const auto kind = b_to_a == std::array{0, 0, 0} ? IntersectionKind::Overlap : IntersectionKind::Crossing;
  for (int i = 0; i < 3; ++i) {
    const int j = (i + 1) % 3;
    if (auto point = segment_meets(a[i], a[j], {a_to_b[i], a_to_b[j]}, b)) return PairVerdict{kind, *point};
    if (auto point = segment_meets(b[i], b[j], {b_to_a[i], b_to_a[j]}, a)) return PairVerdict{kind, *point};
  }
  return std::nullopt;
}

// A line through the shared vertex 0 along a side of `a` has `a` on one side and `b` on the other, in projection. Most
// neighbours in a smooth surface end here, without a test in space.
bool separated_in_projection(const Corners& a, const Corners& b, int axis) {
  for (const int i : {1, 2}) {
    const int own = side(a[0], a[i], a[3 - i], axis);
    if (own != 0 && side(a[0], a[i], b[1], axis) * own < 0 && side(a[0], a[i], b[2], axis) * own < 0) return true;
  }
  return false;
}

//      b1          b2       The triangles share corner 0. What they have in common is star-shaped around it, so if it
//        \ second /         is more than that corner it reaches the side opposite to 0 in one of them.
//         \      /
//          \    /
//   a1 ------ 0 ------ a2
std::optional<PairVerdict> check_shared_vertex(const Corners& a, const Corners& b) {
  const int axis = projection_axis(a);
  if (separated_in_projection(a, b, axis) || separated_in_projection(b, a, axis)) return std::nullopt;
  const std::pair<int, int> b_to_a{orient3d(a[0], a[1], a[2], b[1]), orient3d(a[0], a[1], a[2], b[2])};
  if (b_to_a.first * b_to_a.second > 0) return std::nullopt;
  const std::pair<int, int> a_to_b{orient3d(b[0], b[1], b[2], a[1]), orient3d(b[0], b[1], b[2], a[2])};
  if (a_to_b.first * a_to_b.second > 0) return std::nullopt;
  const auto kind =
      b_to_a == std::pair{0, 0} && a_to_b == std::pair{0, 0} ? IntersectionKind::Overlap : IntersectionKind::Crossing;
  if (auto point = segment_meets(b[1], b[2], b_to_a, a)) return PairVerdict{kind, *point};
  if (auto point = segment_meets(a[1], a[2], a_to_b, b)) return PairVerdict{kind, *point};
  return std::nullopt;
}

// Corners 0 and 1 are shared: the triangles meet beyond that edge only when one is folded onto the other.
std::optional<PairVerdict> check_shared_edge(const Corners& a, const Corners& b) {
  const int axis = projection_axis(a);
  const int own = side(a[0], a[1], a[2], axis), other = side(a[0], a[1], b[2], axis);
  if (own * other <= 0 || orient3d(a[0], a[1], a[2], b[2]) != 0) return std::nullopt;
  return PairVerdict{IntersectionKind::Overlap, (a[0] + a[1] + b[2]) / 3};
}

}  // namespace

bool is_degenerate(const Vec3& a, const Vec3& b, const Vec3& c) {
  for (int axis = 0; axis < 3; ++axis) {
    if (side(a, b, c, axis) != 0) return false;
  }
  return true;
}

std::optional<PairVerdict> check_pair(std::span<const Vec3> points, const TriangleVertices& first,
                                      const TriangleVertices& second) {
  // Brings the shared vertices to the front, in the same order in both.
  TriangleVertices p = first, q = second;
  int shared = 0;
  for (int i = 0; i < 3; ++i) {
    for (int j = shared; j < 3; ++j) {
      if (p[i] != q[j]) continue;
      std::swap(p[i], p[shared]);
      std::swap(q[j], q[shared]);
      ++shared;
      break;
    }
  }
  const Corners a{points[p[0]], points[p[1]], points[p[2]]}, b{points[q[0]], points[q[1]], points[q[2]]};
  switch (shared) {
    case 0: return check_apart(a, b);
    case 1: return check_shared_vertex(a, b);
    case 2: return check_shared_edge(a, b);
    default: return PairVerdict{IntersectionKind::Overlap, (a[0] + a[1] + a[2]) / 3};
  }
}

}  // namespace tetloom::intersection
