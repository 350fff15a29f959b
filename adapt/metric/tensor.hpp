#pragma once
// Symmetric 3x3 tensors: metrics, their logarithms, Hessians.
//
// A metric M is a tensor with positive eigenvalues. The vector e has the length sqrt(eᵀ M e) in it; along an
// eigenvector with the eigenvalue λ the size asked for is 1 / sqrt(λ). So "larger" metrics ask for smaller sizes.
// Interpolation and means are taken of logarithms (Arsigny, Fillard, Pennec & Ayache 2006): the result is a metric, its
// determinant is the geometric mean, and aspect ratios lose no digits in storage, which the entries of M do.
//
// Accuracy: eigenvalues carry an error of some 1e-16 times the largest one, and eigenvectors are orthonormal to
// round-off, whether eigenvalues repeat or not. So the large sizes of a metric given by its entries are known up to
// aspect ratios (of sizes) of about 1e7, further where the eigenvectors lie along the axes; those of a metric given by
// its logarithm always are.
//
// Thread safety: pure functions. Nothing here throws.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

#include "core/base/vec.hpp"

namespace tetloom::adapt {

/// The lower triangle, row by row, which is the order of MEDIT files. Default: zero.
struct Tensor {
  double xx = 0, xy = 0, yy = 0, xz = 0, yz = 0, zz = 0;

  constexpr Tensor& operator+=(const Tensor& b) {
    xx += b.xx, xy += b.xy, yy += b.yy, xz += b.xz, yz += b.yz, zz += b.zz;
    return *this;
  }
  constexpr Tensor& operator-=(const Tensor& b) {
    xx -= b.xx, xy -= b.xy, yy -= b.yy, xz -= b.xz, yz -= b.yz, zz -= b.zz;
    return *this;
  }
  constexpr Tensor& operator*=(double s) {
    xx *= s, xy *= s, yy *= s, xz *= s, yz *= s, zz *= s;
    return *this;
  }
  friend constexpr bool operator==(const Tensor&, const Tensor&) = default;
};

constexpr Tensor operator+(Tensor a, const Tensor& b) { return a += b; }
constexpr Tensor operator-(Tensor a, const Tensor& b) { return a -= b; }
constexpr Tensor operator*(double s, Tensor a) { return a *= s; }
constexpr Tensor operator*(Tensor a, double s) { return a *= s; }

constexpr Tensor diagonal(double xx, double yy, double zz) { return {xx, 0, yy, 0, 0, zz}; }
/// The metric of size `h` in every direction. Pre: h > 0.
constexpr Tensor isotropic(double h) { return diagonal(1 / (h * h), 1 / (h * h), 1 / (h * h)); }
/// s v vᵀ.
constexpr Tensor outer(const Vec3& v, double s = 1) {
  return {s * v.x * v.x, s * v.x * v.y, s * v.y * v.y, s * v.x * v.z, s * v.y * v.z, s * v.z * v.z};
}

/// M v.
constexpr Vec3 operator*(const Tensor& m, const Vec3& v) {
  return {m.xx * v.x + m.xy * v.y + m.xz * v.z, m.xy * v.x + m.yy * v.y + m.yz * v.z,
          m.xz * v.x + m.yz * v.y + m.zz * v.z};
}
/// eᵀ M e: the squared length of e in the metric M.
constexpr double dot(const Tensor& m, const Vec3& e) {
  return m.xx * (e.x * e.x) + m.yy * (e.y * e.y) + m.zz * (e.z * e.z) +
         2 * (m.xy * (e.x * e.y) + m.xz * (e.x * e.z) + m.yz * (e.y * e.z));
}
/// aᵀ M b.
constexpr double dot(const Vec3& a, const Tensor& m, const Vec3& b) { return dot(a, m * b); }
constexpr double trace(const Tensor& m) { return m.xx + m.yy + m.zz; }
constexpr double det(const Tensor& m) {
  return m.xx * (m.yy * m.zz - m.yz * m.yz) - m.xy * (m.xy * m.zz - m.yz * m.xz) + m.xz * (m.xy * m.yz - m.yy * m.xz);
}
inline bool is_finite(const Tensor& m) {
  return std::isfinite(m.xx) && std::isfinite(m.xy) && std::isfinite(m.yy) && std::isfinite(m.xz) &&
         std::isfinite(m.yz) && std::isfinite(m.zz);
}

/// The logarithmic mean (a - b) / log(a / b) of two lengths: the length of an edge whose density changes geometrically
/// from one end to the other. Symmetric, and between a and b. Pre: a, b >= 0.
inline double logarithmic_mean(double a, double b) {
  const double sum = a + b;
  if (!(sum > 0)) return sum;
  const double r = (a - b) / sum;
  const double r2 = r * r;
  // log(a / b) = 2 atanh(r); the series of r / atanh(r) is exact to 1e-12 here.
  if (r2 < 0.0025) return 0.5 * sum * (1 - r2 * (1.0 / 3 + r2 * (4.0 / 45 + r2 * (44.0 / 945))));
  const double small = a < b ? a : b, large = a < b ? b : a;
  return small > 0 ? (large - small) / std::log(large / small) : 0;
}

/// The length of the edge e between two vertices with the metrics `ma` and `mb` (Alauzet 2010, geometric variation of
/// the size along the edge).
inline double edge_length(const Tensor& ma, const Tensor& mb, const Vec3& e) {
  return logarithmic_mean(std::sqrt(dot(ma, e)), std::sqrt(dot(mb, e)));
}

/// Where on an edge the length from its first end is `share` of the whole, by the lengths that its ends give it: sizes
/// change geometrically on the way. Not within a tenth of an end.
inline double place_on_edge(double la, double lb, double share) {
  const double r = lb / la;
  if (!(std::abs(r - 1) > 1e-3)) return share;
  const double s = std::log1p(share * (r - 1)) / std::log(r);
  return std::isfinite(s) ? std::clamp(s, 0.1, 0.9) : share;
}

/// Eigenvalues in ascending order, and a right-handed orthonormal basis of eigenvectors.
struct EigenSystem {
  std::array<double, 3> values{};
  std::array<Vec3, 3> vectors{};
};

/// By cyclic Jacobi rotations (Golub & Van Loan, 8.5). A tensor with NaN or infinite entries gives anything.
EigenSystem eigen(const Tensor& m);

/// Σ value vector vectorᵀ.
constexpr Tensor compose(const EigenSystem& e) {
  return outer(e.vectors[0], e.values[0]) + outer(e.vectors[1], e.values[1]) + outer(e.vectors[2], e.values[2]);
}

/// The tensor with the same eigenvectors and f of the eigenvalues.
template <class Function>
Tensor map_eigenvalues(const Tensor& m, const Function& f) {
  EigenSystem e = eigen(m);
  for (double& value : e.values) value = f(value);
  return compose(e);
}

/// Finite, and every eigenvalue positive.
bool is_positive_definite(const Tensor& m);

/// The logarithm of a metric. Pre: is_positive_definite(m).
Tensor log(const Tensor& m);
/// The metric with that logarithm.
Tensor exp(const Tensor& logarithm);
/// log(isotropic(h)). Pre: h > 0.
inline Tensor log_isotropic(double h) {
  const double l = -2 * std::log(h);
  return diagonal(l, l, l);
}

/// The metric that asks for the smaller of two sizes in each direction of the basis in which both are diagonal
/// (simultaneous reduction, Alauzet & Frey 2003). Not smaller than either: dot(result, e) >= max(dot(a, e), dot(b, e))
/// up to round-off. Returns `a` or `b` itself where it is not smaller than the other. Symmetric up to round-off, but
/// not associative. Pre: both positive definite.
Tensor intersection(const Tensor& a, const Tensor& b);

}  // namespace tetloom::adapt
