#include "adapt/kernel/ring_in_metric.hpp"

#include <algorithm>

#include "adapt/kernel/quality_pairs.hpp"
#include "core/predicates/predicates.hpp"

namespace tetloom::adapt {

using tets::pairs::Pair;
using tets::pairs::pair_of;

RingInMetric::RingInMetric(const CavityMesh& mesh, const tets::EdgeRing& ring)
    : a_(mesh.point(ring.a)),
      b_(mesh.point(ring.b)),
      metric_of_a_(mesh.to_metric[ring.a]),
      metric_of_b_(mesh.to_metric[ring.b]),
      surely_positive_(mesh.surely_positive()) {
  for (std::size_t i = 0; i < ring.old().size(); ++i)
    points_[i] = &mesh.point(ring.verts[i]), metrics_[i] = &mesh.to_metric[ring.verts[i]];
}

double RingInMetric::worse_over(int i, int j, int k) const {
  const auto at = [](int place) { return static_cast<std::size_t>(place); };
  const Vec3 &p = *points_[at(i)], &q = *points_[at(j)], &r = *points_[at(k)];
  const VertexMetric* metric = metrics_[at(i)];
  for (const int other : {j, k})
    if (metrics_[at(other)]->det > metric->det) metric = metrics_[at(other)];
  const Vec3 pq = q - p, pr = r - p;
  const Pair qualities = cubed_mean_ratio(pair_of(pq, pr), pair_of(pr, pq), pair_of(b_ - p, a_ - p),
                                          metric_of_b_.det > metric->det ? metric_of_b_ : *metric,
                                          metric_of_a_.det > metric->det ? metric_of_a_ : *metric);
  const double least = std::min(qualities[0], qualities[1]);
  if (least > surely_positive_ || !(least > 0)) return least;
  return orient3d(p, q, r, b_) > 0 && orient3d(p, r, q, a_) > 0 ? least : 0;
}

}  // namespace tetloom::adapt
