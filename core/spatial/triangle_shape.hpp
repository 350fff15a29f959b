#pragma once
// What a triangle in space looks like.
#include <cmath>

#include "tetloom/vec.hpp"

namespace tetloom {

/// Of length 1, to the side from which a, b, c turn counter-clockwise; zero without area.
inline Vec3 triangle_normal(const Vec3& a, const Vec3& b, const Vec3& c) { return normalized(cross(b - a, c - a)); }

/// The mean ratio of a triangle: 1 for an equilateral one, 0 for one without area.
inline double triangle_mean_ratio(const Vec3& a, const Vec3& b, const Vec3& c) {
  const Vec3 p = b - a, q = c - a;
  const double squares = norm2(p) + norm2(q) + norm2(q - p);
  return squares > 0 ? 2 * std::sqrt(3.0) * norm(cross(p, q)) / squares : 0;
}

}  // namespace tetloom
