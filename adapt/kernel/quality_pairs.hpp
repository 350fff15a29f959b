#pragma once
// Qualities of two tets at a time.
#include "adapt/metric/vertex_metric.hpp"
#include "core/tets/tet_pairs.hpp"

namespace tetloom::adapt {

/// The cubed mean ratios of two tets with edges p, q, r, each in its metric.
inline tets::pairs::Pair cubed_mean_ratio(const tets::pairs::PairVec& p, const tets::pairs::PairVec& q,
                                          const tets::pairs::PairVec& r, const VertexMetric& one,
                                          const VertexMetric& other) {
  using tets::pairs::Pair;
  using tets::pairs::PairVec;
  const Tensor &m = one.tensor, &n = other.tensor;
  const Pair volume = dot(cross(p, q), r);
  const PairVec s = p + q + r;
  const auto sum = [&](Pair PairVec::*i, Pair PairVec::*j) {
    return 4 * (p.*i * p.*j + q.*i * q.*j + r.*i * r.*j) - s.*i * s.*j;
  };
  const Pair squares =
      Pair{m.xx, n.xx} * sum(&PairVec::x, &PairVec::x) + Pair{m.yy, n.yy} * sum(&PairVec::y, &PairVec::y) +
      Pair{m.zz, n.zz} * sum(&PairVec::z, &PairVec::z) +
      2 * (Pair{m.xy, n.xy} * sum(&PairVec::x, &PairVec::y) + Pair{m.xz, n.xz} * sum(&PairVec::x, &PairVec::z) +
           Pair{m.yz, n.yz} * sum(&PairVec::y, &PairVec::z));
  const Pair quality = 432 * volume * volume * Pair{one.det, other.det} / (squares * squares * squares);
  return volume > 0 ? quality : Pair{};
}

}  // namespace tetloom::adapt
