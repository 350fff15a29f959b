#pragma once
// The quality of a tetrahedron: mean ratio q = 12 (3V)^(2/3) / (sum of squared edges), 1 for a regular one.
//
// Everything here works with q cubed, which needs no root: 432 v^2 / s^3 with v six times the volume and s the sum of
// squared edges. Differences of coordinates are exact up to one rounding, so a computed v is off by less than
// 1e-14 s^(3/2) wherever the tet lies: a q cubed above kSurelyPositive proves that orient3d > 0.
#include <cmath>

#include "tetloom/vec.hpp"

namespace tetloom::tets {

/// 432 * (1e-14)^2 is 4e-26.
inline constexpr double kSurelyPositive = 1e-20;
/// What "better" means: by more than the rounding of a float.
inline constexpr double kGain = 1 + 1e-4;

inline double cube(double x) { return x * x * x; }

/// From six times the volume and the sum of squared edges; 0 for what is flat or inverted.
inline double cubed_quality(double volume6, double squares) {
  return volume6 > 0 ? 432 * volume6 * volume6 / cube(squares) : 0;
}

inline double cubed_quality(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) {
  const Vec3 p = b - a, q = c - a, r = d - a;
  const double squares = norm2(p) + norm2(q) + norm2(r) + norm2(q - p) + norm2(r - p) + norm2(r - q);
  return cubed_quality(dot(cross(p, q), r), squares);
}

}  // namespace tetloom::tets
