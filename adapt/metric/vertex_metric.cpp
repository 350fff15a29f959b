#include "adapt/metric/vertex_metric.hpp"

#include <limits>

namespace tetloom::adapt {

namespace {

constexpr double kTwiceTheBound = 9e-28;
constexpr double kLeastOfTrace = 1e-10;  // eigenvalue for which roundings are small
// Of the cubed trace to the determinant. Eigenvalues a <= b <= c have c / a below it, and a >= 4 det / trace^2, so that
// det / a^3 is at most its square by 64.
constexpr double kMild = 1e10;
constexpr double kBoundOfMild = kTwiceTheBound * kMild * kMild / 64;

// Not above the smallest eigenvalue: the inverse of the trace of the inverse, by M = L D transpose(L). 0: none is
// known.
double smallest_eigenvalue(const Tensor& m) {
  const double xy = m.xy / m.xx, xz = m.xz / m.xx;
  const double dy = m.yy - xy * m.xy, yz = (m.yz - xz * m.xy) / dy;
  const double dz = m.zz - xz * m.xz - yz * yz * dy;
  if (!(m.xx > 0 && dy > 0 && dz > 0)) return 0;
  const double corner = xy * yz - xz;
  return 1 / (1 / m.xx + (1 + xy * xy) / dy + (1 + yz * yz + corner * corner) / dz);
}

}  // namespace

double surely_positive_quality(const VertexMetric& metric) {
  const double all = trace(metric.tensor);
  if (all * all * all < kMild * metric.det) return kBoundOfMild;
  const double least = smallest_eigenvalue(metric.tensor);
  if (!(metric.det > 0 && least > kLeastOfTrace * all)) return std::numeric_limits<double>::infinity();
  return kTwiceTheBound * metric.det / (least * least * least);
}

}  // namespace tetloom::adapt
