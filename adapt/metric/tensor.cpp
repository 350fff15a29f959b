#include "tetloom/metric.hpp"

#include <algorithm>
#include <limits>

namespace tetloom::adapt {
namespace {

/// Turns the axes P and Q so that the entry between them vanishes; R is the third axis. `m` is the upper triangle of
/// what is left to be made diagonal, v[axis] the eigenvectors so far.
template <int P, int Q, int R>
void rotate(double (&m)[3][3], std::array<Vec3, 3>& v) {
  double& off = m[P][Q];
  if (off == 0) return;
  double& p = m[P][P];
  double& q = m[Q][Q];
  const double tiny = 64 * std::abs(off);
  if (std::abs(p) + tiny == std::abs(p) && std::abs(q) + tiny == std::abs(q)) {
    off = 0;
    return;
  }
  const double theta = (q - p) / (2 * off);
  const double t = std::copysign(1 / (std::abs(theta) + std::sqrt(theta * theta + 1)), theta);
  const double c = 1 / std::sqrt(t * t + 1), s = t * c;
  p -= t * off;
  q += t * off;
  off = 0;
  double& pr = m[std::min(P, R)][std::max(P, R)];
  double& qr = m[std::min(Q, R)][std::max(Q, R)];
  const double old_pr = pr;
  pr = c * old_pr - s * qr;
  qr = s * old_pr + c * qr;
  const Vec3 old_p = v[P];
  v[P] = c * old_p - s * v[Q];
  v[Q] = s * old_p + c * v[Q];
}

void sort_ascending(EigenSystem& e) {
  const auto swap_if = [&](std::size_t i, std::size_t j) {
    if (e.values[i] <= e.values[j]) return;
    std::swap(e.values[i], e.values[j]);
    std::swap(e.vectors[i], e.vectors[j]);
    e.vectors[i] = -e.vectors[i];  // stays right-handed
  };
  swap_if(0, 1), swap_if(1, 2), swap_if(0, 1);
}

/// a + b B + c B² for a tensor B without trace, whose powers all have this form: B³ = p B + q by the theorem of Cayley
/// and Hamilton, with p = trace(B²) / 2 and q = det(B).
struct Quadratic {
  double a, b, c;
};

/// exp(B) by its Taylor series. Pre: the norm of B is at most 1/4.
Quadratic exp_series(double p, double q) {
  Quadratic sum{1, 1, 0.5};
  Quadratic term = {0, 0, 0.5};  // Bⁿ / n!
  for (int n = 3; n <= 11; ++n) {
    const double f = 1.0 / n;
    term = {f * term.c * q, f * (term.a + term.c * p), f * term.b};
    sum.a += term.a, sum.b += term.b, sum.c += term.c;
  }
  return sum;
}

Quadratic squared(const Quadratic& x, double p, double q) {
  const double bc = 2 * x.b * x.c, cc = x.c * x.c;
  return {x.a * x.a + bc * q, 2 * x.a * x.b + bc * p + cc * q, x.b * x.b + 2 * x.a * x.c + cc * p};
}

/// The square of a tensor.
Tensor squared(const Tensor& m) {
  return {m.xx * m.xx + m.xy * m.xy + m.xz * m.xz, m.xx * m.xy + m.xy * m.yy + m.xz * m.yz,
          m.xy * m.xy + m.yy * m.yy + m.yz * m.yz, m.xx * m.xz + m.xy * m.yz + m.xz * m.zz,
          m.xy * m.xz + m.yy * m.yz + m.yz * m.zz, m.xz * m.xz + m.yz * m.yz + m.zz * m.zz};
}

}  // namespace

EigenSystem eigen(const Tensor& m) {
  constexpr int kMostSweeps = 16;  // four suffice, as convergence is quadratic
  double a[3][3] = {{m.xx, m.xy, m.xz}, {0, m.yy, m.yz}, {0, 0, m.zz}};
  EigenSystem e;
  e.vectors = {Vec3{1, 0, 0}, Vec3{0, 1, 0}, Vec3{0, 0, 1}};
  for (int sweep = 0; sweep < kMostSweeps; ++sweep) {
    if (a[0][1] == 0 && a[0][2] == 0 && a[1][2] == 0) break;
    rotate<0, 1, 2>(a, e.vectors);
    rotate<0, 2, 1>(a, e.vectors);
    rotate<1, 2, 0>(a, e.vectors);
  }
  e.values = {a[0][0], a[1][1], a[2][2]};
  sort_ascending(e);
  return e;
}

bool is_positive_definite(const Tensor& m) { return is_finite(m) && eigen(m).values[0] > 0; }

Tensor log(const Tensor& m) {
  return map_eigenvalues(m, [](double value) { return std::log(value); });
}

Tensor exp(const Tensor& logarithm) {
  // The mean of the logarithms is a factor; the rest B is halved until the series converges fast, and squared again.
  // Every squaring doubles the error, so strong anisotropy takes the longer way.
  constexpr double kLargest = 8;
  const double mean = trace(logarithm) / 3;
  const Tensor rest = logarithm - diagonal(mean, mean, mean);
  Tensor square = squared(rest);
  const double norm2 = trace(square);
  if (!(norm2 < kLargest * kLargest)) return map_eigenvalues(logarithm, [](double value) { return std::exp(value); });
  int halvings = 0;
  double scale = 1;
  while (norm2 * scale * scale > 0.0625) scale *= 0.5, ++halvings;
  const double p = norm2 / 2 * scale * scale, q = det(rest) * scale * scale * scale;
  Quadratic sum = exp_series(p, q);
  for (int i = 0; i < halvings; ++i) sum = squared(sum, p, q);
  const double factor = std::exp(mean);
  square *= factor * sum.c * scale * scale;
  const double a = factor * sum.a;
  return diagonal(a, a, a) + (factor * sum.b * scale) * rest + square;
}

Tensor intersection(const Tensor& a, const Tensor& b) {
  if (a == b) return a;
  // In the frame where a is the unit metric, b keeps its eigenvectors while those of its eigenvalues that are below 1
  // become 1.
  const EigenSystem of_a = eigen(a);
  std::array<Vec3, 3> root, inverse_root;  // columns of a^(1/2) and its inverse, in the basis of a's eigenvectors
  for (std::size_t i = 0; i < 3; ++i) {
    const double length = std::sqrt(of_a.values[i]);
    root[i] = length * of_a.vectors[i];
    inverse_root[i] = of_a.vectors[i] / length;
  }
  const auto entry = [&](std::size_t i, std::size_t j) { return dot(inverse_root[i], b, inverse_root[j]); };
  EigenSystem reduced = eigen({entry(0, 0), entry(0, 1), entry(1, 1), entry(0, 2), entry(1, 2), entry(2, 2)});
  constexpr double kSlack = 8 * std::numeric_limits<double>::epsilon();
  if (reduced.values[2] <= 1 + kSlack) return a;
  if (reduced.values[0] >= 1 - kSlack) return b;
  for (std::size_t i = 0; i < 3; ++i) {
    const Vec3 w = reduced.vectors[i];
    reduced.vectors[i] = w.x * root[0] + w.y * root[1] + w.z * root[2];
    reduced.values[i] = std::max(1.0, reduced.values[i]);
  }
  return compose(reduced);
}

}  // namespace tetloom::adapt
