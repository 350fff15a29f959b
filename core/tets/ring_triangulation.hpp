#pragma once
// The best triangulation of the ring of an edge, by dynamic programming over sub-polygons (Klincsek 1980).
//
// The polygon is that of an edge's ring, closed from its last vertex to its first: for a ring that is open, at an edge
// of the surface, the closing edge is what takes the place of the edge there.
#include <algorithm>
#include <cstdint>

#include "core/tets/edge_ring.hpp"

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

}  // namespace tetloom::tets
