#include "core/spatial/distances.hpp"

namespace tetloom {
namespace {

constexpr double kRounded = 1e-12;  // of coordinates and distances

TrianglePoint at(const Vec3& x, const Vec3& a, const Vec3& b, const Vec3& c, const std::array<double, 3>& weights) {
  return {weights, norm2(x - (weights[0] * a + weights[1] * b + weights[2] * c))};
}

/// How far along from `a` to `b` the nearest point lies, from 0 to 1.
double along(double to_a, double to_b) { return to_a <= 0 ? 0 : to_b <= 0 ? 1 : to_a / (to_a + to_b); }

}  // namespace

double reach_of_boxes(double distance2, const Vec3& x) {
  const double distance = std::sqrt(distance2);
  const double reach = distance + kRounded * (distance + std::max({std::abs(x.x), std::abs(x.y), std::abs(x.z)}));
  return reach * reach;
}

TrianglePoint closest_on_triangle(const Vec3& x, const Vec3& a, const Vec3& b, const Vec3& c) {
  const Vec3 ab = b - a, ac = c - a, normal = cross(ab, ac);
  const double area2 = norm2(normal);
  const Vec3 ax = x - a, bx = x - b, cx = x - c;
  if (area2 > 0) {
    const double wc = dot(cross(ab, ax), normal), wa = dot(cross(c - b, bx), normal);
    const double wb = area2 - wc - wa;
    if (wa >= 0 && wb >= 0 && wc >= 0) return at(x, a, b, c, {wa / area2, wb / area2, wc / area2});
  }
  // The nearest of three edges: simple, and safe for triangles without area.
  const double tab = along(dot(ax, ab), -dot(bx, ab)), tac = along(dot(ax, ac), -dot(cx, ac));
  const double tbc = along(dot(bx, c - b), -dot(cx, c - b));
  TrianglePoint best = at(x, a, b, c, {1 - tab, tab, 0});
  for (const auto& weights : {std::array<double, 3>{1 - tac, 0, tac}, std::array<double, 3>{0, 1 - tbc, tbc}}) {
    const TrianglePoint other = at(x, a, b, c, weights);
    if (other.distance2 < best.distance2) best = other;
  }
  return best;
}

}  // namespace tetloom
