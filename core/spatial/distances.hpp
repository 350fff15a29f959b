#pragma once
// How far a point is from boxes, segments and triangles, all closed, and the nearest points of those.
#include <algorithm>
#include <array>
#include <cmath>

#include "tetloom/vec.hpp"

namespace tetloom {

/// The squared distance from `x` to the nearest point of `box`; infinite for an empty one.
inline double squared_distance_to_box(const Vec3& x, const Box3& box) {
  const auto outside = [](double value, double lo, double hi) {  // without branches: nobody can foretell them
    return std::max(std::max(lo - value, value - hi), 0.0);
  };
  const double dx = outside(x.x, box.lo.x, box.hi.x), dy = outside(x.y, box.lo.y, box.hi.y),
               dz = outside(x.z, box.lo.z, box.hi.z);
  return dx * dx + dy * dy + dz * dz;
}

/// The squared distance from `x` to the segment from `a` to `b`, which may be one point.
inline double squared_distance_to_segment(const Vec3& x, const Vec3& a, const Vec3& b) {
  const Vec3 along = b - a;
  const double length2 = norm2(along);
  const double t = length2 > 0 ? std::clamp(dot(x - a, along) / length2, 0.0, 1.0) : 0.0;
  return norm2(x - (a + t * along));
}

inline double distance_to_segment(const Vec3& x, const Vec3& a, const Vec3& b) {
  return std::sqrt(squared_distance_to_segment(x, a, b));
}

/// The distance from `x` to the triangle a, b, c; right up to rounding, for degenerate triangles too.
inline double distance_to_triangle(const Vec3& x, const Vec3& a, const Vec3& b, const Vec3& c) {
  const Vec3 normal = cross(b - a, c - a);
  const double area2 = norm2(normal);
  const bool above = area2 > 0 && dot(cross(b - a, x - a), normal) >= 0 && dot(cross(c - b, x - b), normal) >= 0 &&
                     dot(cross(a - c, x - c), normal) >= 0;
  if (above) return std::abs(dot(x - a, normal)) / std::sqrt(area2);
  return std::sqrt(std::min({squared_distance_to_segment(x, a, b), squared_distance_to_segment(x, b, c),
                             squared_distance_to_segment(x, c, a)}));
}

/// The point of a triangle that is nearest to some other point, by its barycentric coordinates.
struct TrianglePoint {
  std::array<double, 3> weights{};  ///< not negative, sum 1
  double distance2 = HUGE_VAL;      ///< squared
};

/// After Ericson, "Real-time collision detection" (2005), 5.1.5. Triangles without area give the nearest point of
/// their sides.
TrianglePoint closest_on_triangle(const Vec3& x, const Vec3& a, const Vec3& b, const Vec3& c);

/// How far something may be away, squared, that is to be looked at where the nearest known so far is at a squared
/// distance of `distance2` from x: a little more than that, so that what is found as nearest does not depend on the
/// order of looking, whatever was rounded.
double reach_of_boxes(double distance2, const Vec3& x);

}  // namespace tetloom
