#pragma once
// The best triangulation of the ring of an edge, by dynamic programming over sub-polygons (Klincsek 1980).
//
// The polygon is that of an edge's ring, closed from its last vertex to its first: for a ring that is open, at an edge
// of the surface, the closing edge is what takes the place of the edge there.
#include <algorithm>
#include <array>
#include <cstdint>

#include "mesher/tets/edge_removal.hpp"

namespace tetloom::tets {

// Chooses the triangulation of one ring.
class RingTriangulation {
 public:
  using Tets = std::array<NewTet, std::size_t{2} * kMostRingVerts>;

  RingTriangulation(const WorkingMesh& mesh, const EdgeRing& ring) : ring_(ring), origin_(mesh.point(ring.a)) {
    b_ = mesh.point(ring.b) - origin_;
    for (int i = 0; i < ring.count; ++i) {
      points_[i] = mesh.point(ring.verts[i]) - origin_;
      to_a_[i] = norm2(points_[i]);
      to_b_[i] = norm2(points_[i] - b_);
    }
  }

  // The largest minimum, or something not above `goal` when there is none above it.
  double maximize(double goal) {
    const int n = ring_.count;
    for (int i = 0; i + 1 < n; ++i) best_[i][i + 1] = 2;
    for (int width = 2; width < n; ++width) {
      for (int i = 0; i + width < n; ++i) best_[i][i + width] = best_of(i, i + width, goal);
    }
    return best_[0][n - 1];
  }

  // The tets of the triangulation that `maximize` found.
  int build(Tets& made) const {
    int count = 0;
    build(0, ring_.count - 1, made, count);
    return count;
  }

 private:
  double best_of(int i, int j, double goal) {
    double best = 0;
    for (int k = i + 1; k < j; ++k) {
      const double bound = std::min(best_[i][k], best_[k][j]);
      if (bound <= std::max(best, goal)) continue;
      const double value = std::min(bound, quality_of(i, k, j));
      if (value > best) best = value, apex_[i][j] = static_cast<std::uint8_t>(k);
    }
    return best;
  }

  // Of the worse of the two tets over one triangle.
  double quality_of(int i, int j, int k) const {
    const Vec3 &p = points_[i], &q = points_[j], &r = points_[k];
    const Vec3 normal = cross(q - p, r - p);
    const double below = dot(normal, p), above = dot(normal, b_ - p);
    if (!(below > 0 && above > 0)) return 0;
    const double sides = norm2(q - p) + norm2(r - q) + norm2(p - r);
    return std::min(cubed_quality(below, sides + to_a_[i] + to_a_[j] + to_a_[k]),
                    cubed_quality(above, sides + to_b_[i] + to_b_[j] + to_b_[k]));
  }

  void build(int i, int j, Tets& made, int& count) const {
    if (j - i < 2) return;
    const int k = apex_[i][j];
    const std::uint32_t p = ring_.verts[i], q = ring_.verts[k], r = ring_.verts[j];
    const Vec3 zero;
    made[count++] = {{p, q, r, ring_.b}, cubed_quality(points_[i], points_[k], points_[j], b_)};
    made[count++] = {{p, r, q, ring_.a}, cubed_quality(points_[i], points_[j], points_[k], zero)};
    build(i, k, made, count);
    build(k, j, made, count);
  }

  const EdgeRing& ring_;
  Vec3 origin_, b_;
  std::array<Vec3, kMostRingVerts> points_;
  std::array<double, kMostRingVerts> to_a_, to_b_;
  double best_[kMostRingVerts][kMostRingVerts];
  std::uint8_t apex_[kMostRingVerts][kMostRingVerts];
};

}  // namespace tetloom::tets
