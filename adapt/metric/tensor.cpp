#include "adapt/metric/tensor.hpp"

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
  return map_eigenvalues(logarithm, [](double value) { return std::exp(value); });
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
