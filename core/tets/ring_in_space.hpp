#pragma once
// What RingTriangulation asks of a ring where lengths are those of space.
#include <algorithm>
#include <array>

#include "core/tets/edge_ring.hpp"
#include "core/tets/tet_quality.hpp"
#include "core/tets/working_mesh.hpp"
#include "tetloom/vec.hpp"

namespace tetloom::tets {

/// Mean ratios in space of the tets over a ring, whose vertices are measured from a.
class RingInSpace {
 public:
  RingInSpace(const WorkingMesh& mesh, const EdgeRing& ring) : ring_(ring), origin_(mesh.point(ring.a)) {
    b_ = mesh.point(ring.b) - origin_;
    for (int i = 0; i < ring.count; ++i) {
      points_[i] = mesh.point(ring.verts[i]) - origin_;
      to_a_[i] = norm2(points_[i]);
      to_b_[i] = norm2(points_[i] - b_);
    }
  }

  double worse_over(int i, int j, int k) const {
    const Vec3 &p = points_[i], &q = points_[j], &r = points_[k];
    const Vec3 normal = cross(q - p, r - p);
    const double below = dot(normal, p), above = dot(normal, b_ - p);
    if (!(below > 0 && above > 0)) return 0;
    const double sides = norm2(q - p) + norm2(r - q) + norm2(p - r);
    return std::min(cubed_quality(below, sides + to_a_[i] + to_a_[j] + to_a_[k]),
                    cubed_quality(above, sides + to_b_[i] + to_b_[j] + to_b_[k]));
  }

  /// The tets over a triangle, at b and at a.
  std::array<NewTet, 2> tets(const RingTriangle& triangle) const {
    const auto [at_b, at_a] = tets_over(ring_, triangle);
    const Vec3 &p = points_[triangle.first], &q = points_[triangle.middle], &r = points_[triangle.last];
    return {{{at_b, cubed_quality(p, q, r, b_)}, {at_a, cubed_quality(p, r, q, {})}}};
  }

 private:
  const EdgeRing& ring_;
  Vec3 origin_, b_;
  std::array<Vec3, kMostRingVerts> points_;
  std::array<double, kMostRingVerts> to_a_, to_b_;
};

}  // namespace tetloom::tets
