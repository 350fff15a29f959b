#pragma once
// How fine a curved edge or face must be meshed: the one rule behind SizeOptions::curvature.
//
// Let a mesh of triangles with edges of length h be inscribed in a surface with principal curvatures k1 >= k2 >= 0.
// - Over an equilateral triangle the mean sag between facet and surface is h² (k1 + k2) / 16.
// - The slice of the body under a piece of surface, down to the nearer centre of curvature at depth 1/k1, has the
// volume
//   ∫ (1 - k1 z)(1 - k2 z) dz = (3 - q) / (6 k1) per area, with q = k2 / k1 (a cylinder's r/2, a sphere's r/3).
// - The relative loss of volume is their quotient, 3/8 h² k1² (1 + q) / (3 - q), which within 3 % for 0 <= q <= 1 is
//
//       loss = h² K² / 8   with   K² = k1² + |k1 k2| + k2²
//
//   (exact for cylinders, K = k, and for spheres, K = √3 k). On a torus the two signs of k2 cancel and the loss is that
//   of a cylinder; the modulus errs on the fine side for saddles.
// - A circular edge of radius 1/k cut into chords of length h loses h² k² / 6 of the disc.
//
// The rule: no curved piece loses more than 4.5 / N² of its volume, that is
//
//     faces   h = 6 / (N K)          edges   h = √27 / (N k)
//
// so that a cylinder has 2π/6 N = 1.05 N edges per turn, a sphere 1.81 N, and a rim 1.21 N: always at least the N asked
// for. At N = 24 the loss is 0.78 %, which leaves room for edges that come out a few percent longer than asked.
#include <cmath>

#include "tetloom/model.hpp"

namespace tetloom {

/// Edge length for a face with the curvatures `k` at `edges_per_turn`; infinite where flat or where there is no
/// curvature to speak of (not a number), 0 where it is infinite.
inline double size_from_curvature(const PrincipalCurvatures& k, double edges_per_turn) {
  const double k1 = k.largest, k2 = k.smallest;
  if (std::isinf(k1) || std::isinf(k2)) return 0;
  const double combined = std::sqrt(k1 * k1 + std::abs(k1 * k2) + k2 * k2);
  return combined > 0 ? 6 / (edges_per_turn * combined) : HUGE_VAL;
}

/// The same for an edge of the model.
inline double size_from_edge_curvature(double k, double edges_per_turn) {
  return std::abs(k) > 0 ? std::sqrt(27.0) / (edges_per_turn * std::abs(k)) : HUGE_VAL;
}

}  // namespace tetloom
