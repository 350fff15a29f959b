#pragma once
// What tets::RingTriangulation asks of a ring.
#include <array>

#include "adapt/kernel/cavity_mesh.hpp"
#include "core/tets/edge_ring.hpp"

namespace tetloom::adapt {

/// Mean ratios in the metric of the tets over a ring; 0 for those that are not positive, exactly.
class RingInMetric {
 public:
  RingInMetric(const CavityMesh& mesh, const tets::EdgeRing& ring);
  double worse_over(int i, int j, int k) const;

 private:
  std::array<const Vec3*, tets::kMostRingVerts> points_;
  std::array<const VertexMetric*, tets::kMostRingVerts> metrics_;
  const Vec3 &a_, &b_;
  const VertexMetric &metric_of_a_, &metric_of_b_;
  double surely_positive_;
};

}  // namespace tetloom::adapt
