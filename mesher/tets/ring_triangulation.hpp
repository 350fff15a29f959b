#pragma once
// The best triangulation of the ring of an edge, by dynamic programming over sub-polygons (Klincsek 1980).
//
// The polygon is that of an edge's ring, closed from its last vertex to its first: for a ring that is open, at an edge
// of the surface, the closing edge is what takes the place of the edge there.
#include <algorithm>
#include <array>
#include <cstdint>

#include "mesher/tets/edge_ring.hpp"
#include "mesher/tets/working_mesh.hpp"

namespace tetloom::tets {

/// Chooses the triangulation of one ring. `Qualities::worse_over(i, j, k)` is the cubed quality of the worse of the two
/// tets over the triangle of these places of the ring, 0 where one is inverted: the metric is the caller's.
template <class Qualities>
class RingTriangulation {
 public:
  RingTriangulation(const Qualities& qualities, int count) : qualities_(qualities), count_(count) {}

  /// The largest minimum, or something not above `goal` when there is none above it.
  double maximize(double goal) {
    for (int i = 0; i + 1 < count_; ++i) best_[i][i + 1] = 2;
    for (int width = 2; width < count_; ++width)
      for (int i = 0; i + width < count_; ++i) best_[i][i + width] = best_of(i, i + width, goal);
    return best_[0][count_ - 1];
  }

  /// The triangulation that `maximize` found.
  RingTriangles triangles() const {
    RingTriangles result;
    collect(0, count_ - 1, result);
    return result;
  }

 private:
  double best_of(int i, int j, double goal) {
    double best = 0;
    for (int k = i + 1; k < j; ++k) {
      const double bound = std::min(best_[i][k], best_[k][j]);
      if (bound <= std::max(best, goal)) continue;
      const double value = std::min(bound, qualities_.worse_over(i, k, j));
      if (value > best) best = value, apex_[i][j] = static_cast<std::uint8_t>(k);
    }
    return best;
  }

  void collect(int i, int j, RingTriangles& result) const {
    if (j - i < 2) return;
    const std::uint8_t k = apex_[i][j];
    result.items[static_cast<std::size_t>(result.count++)] = {static_cast<std::uint8_t>(i), k,
                                                              static_cast<std::uint8_t>(j)};
    collect(i, k, result);
    collect(k, j, result);
  }

  const Qualities& qualities_;
  int count_;
  double best_[kMostRingVerts][kMostRingVerts];
  std::uint8_t apex_[kMostRingVerts][kMostRingVerts];
};

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
