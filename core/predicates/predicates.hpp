#pragma once
// Geometric predicates whose sign is exact: a floating-point filter with an error bound taken from the magnitudes of
// this very call, inline here, and integer arithmetic of any length behind it when the filter cannot decide.
//
// Laws, for all finite coordinates (subnormal and huge ones too): the result is the sign of the determinant over the
// real numbers, so an even permutation of the points of a simplex keeps it, an odd one flips it, and it is 0 exactly
// when the points are collinear, coplanar, cocircular or cospherical. Not guaranteed: anything for NaN or infinite
// coordinates, under another rounding mode than to-nearest, or with subnormals flushed to zero.
// Thread safety: pure functions without state or initialisation. Never throw, never allocate.
// Cost of orient3d and insphere: about 10 and 20 ns when the filter decides; 65 and 150 ns when it does not
// (up to 0.2 ms where the exponents of the coordinates differ by more than about 150).
//
// The filters follow stage A of J. R. Shewchuk, "Adaptive Precision Floating-Point Arithmetic and Fast Robust
// Geometric Predicates" (1997), with slightly larger constants and a term for underflow, which he excludes. The exact
// stage departs from the paper: integers scaled by a common power of two instead of expansions.
#include <cmath>

#include "tetloom/vec.hpp"

namespace tetloom {

namespace detail {
int orient2d_exact(const Vec2& a, const Vec2& b, const Vec2& c);
int orient3d_exact(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d);
int incircle_exact(const Vec2& a, const Vec2& b, const Vec2& c, const Vec2& d);
int insphere_exact(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d, const Vec3& e);

inline constexpr double kRounding = 0x1p-53;  // largest relative error of one operation

// A 2x2 minor together with the sum of its terms' magnitudes.
/// A 2x2 determinant, and the sum of the magnitudes of its two products.
struct Minor {
  double value, magnitude;
};
inline Minor minor_of(double ax, double ay, double bx, double by) {
  const double p = ax * by, q = bx * ay;
  return {p - q, std::abs(p) + std::abs(q)};
}
// x*bc + y*ca + z*ab, and the same of magnitudes.
inline Minor expand(double x, const Minor& bc, double y, const Minor& ca, double z, const Minor& ab) {
  return {x * bc.value + y * ca.value + z * ab.value,
          std::abs(x) * bc.magnitude + std::abs(y) * ca.magnitude + std::abs(z) * ab.magnitude};
}
}  // namespace detail

/// Sign of cross(b - a, c - a): 1 when a, b, c turn counter-clockwise, 0 when they are collinear.
inline int orient2d(const Vec2& a, const Vec2& b, const Vec2& c) {
  const detail::Minor det = detail::minor_of(b.u - a.u, b.v - a.v, c.u - a.u, c.v - a.v);
  // Each product carries 3 roundings, their difference one more; 1e-300 covers what underflow can lose.
  const double bound = 5 * detail::kRounding * det.magnitude + 1e-300;
  if (det.value > bound) return 1;
  if (det.value < -bound) return -1;
  return detail::orient2d_exact(a, b, c);
}

/// Sign of dot(cross(b - a, c - a), d - a): 1 when d lies on the side from which a, b, c turn counter-clockwise (a
/// tetrahedron of positive volume), 0 when the four are coplanar.
inline int orient3d(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) {
  const Vec3 p = b - a, q = c - a, r = d - a;
  const detail::Minor det =
      detail::expand(p.z, detail::minor_of(q.x, q.y, r.x, r.y), q.z, detail::minor_of(r.x, r.y, p.x, p.y), r.z,
                     detail::minor_of(p.x, p.y, q.x, q.y));
  // 8 roundings at most on any path; an underflowing product of x and y is multiplied by a z.
  const double bound =
      9 * detail::kRounding * det.magnitude + 1e-300 * (1 + std::abs(p.z) + std::abs(q.z) + std::abs(r.z));
  if (det.value > bound) return 1;
  if (det.value < -bound) return -1;
  return detail::orient3d_exact(a, b, c, d);
}

/// 1 when d lies inside the circle through a, b, c, -1 when outside, 0 on it; for a, b, c counter-clockwise. The other
/// way round the signs swap.
inline int incircle(const Vec2& a, const Vec2& b, const Vec2& c, const Vec2& d) {
  const Vec2 p = a - d, q = b - d, r = c - d;
  const double p2 = dot(p, p), q2 = dot(q, q), r2 = dot(r, r);
  const detail::Minor det =
      detail::expand(p2, detail::minor_of(q.u, q.v, r.u, r.v), q2, detail::minor_of(r.u, r.v, p.u, p.v), r2,
                     detail::minor_of(p.u, p.v, q.u, q.v));
  // 11 roundings; with differences below 1e50 underflow costs less than 1e-200.
  const double bound = 12 * detail::kRounding * det.magnitude + 1e-200;
  if (p2 + q2 + r2 < 1e100) {
    if (det.value > bound) return 1;
    if (det.value < -bound) return -1;
  }
  return detail::incircle_exact(a, b, c, d);
}

/// 1 when e lies inside the sphere through a, b, c, d, -1 when outside, 0 on it; for orient3d(a, b, c, d) > 0. With the
/// other orientation the signs swap.
inline int insphere(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d, const Vec3& e) {
  using detail::expand, detail::Minor, detail::minor_of;
  const Vec3 p = a - e, q = b - e, r = c - e, s = d - e;
  const Minor pq = minor_of(p.x, p.y, q.x, q.y), qr = minor_of(q.x, q.y, r.x, r.y), rs = minor_of(r.x, r.y, s.x, s.y);
  const Minor sp = minor_of(s.x, s.y, p.x, p.y), pr = minor_of(p.x, p.y, r.x, r.y), qs = minor_of(q.x, q.y, s.x, s.y);
  const Minor pqr = expand(p.z, qr, -q.z, pr, r.z, pq), qrs = expand(q.z, rs, -r.z, qs, s.z, qr);
  const Minor rsp = expand(r.z, sp, s.z, pr, p.z, rs), spq = expand(s.z, pq, p.z, qs, q.z, sp);
  const double p2 = norm2(p), q2 = norm2(q), r2 = norm2(r), s2 = norm2(s);
  const double det = (p2 * qrs.value - q2 * rsp.value) + (r2 * spq.value - s2 * pqr.value);
  const double magnitude = (p2 * qrs.magnitude + q2 * rsp.magnitude) + (r2 * spq.magnitude + s2 * pqr.magnitude);
  // 16 roundings; with differences below 1e50 underflow costs less than 1e-150.
  const double bound = 17 * detail::kRounding * magnitude + 1e-150;
  if (p2 + q2 + r2 + s2 < 1e100) {
    if (det > bound) return 1;
    if (det < -bound) return -1;
  }
  return detail::insphere_exact(a, b, c, d, e);
}

}  // namespace tetloom
