#pragma once
// Distances of a point from boxes, segments and triangles, all closed.
#include <algorithm>
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

}  // namespace tetloom
