#pragma once
// How long the edges of a tet are, two at a time: most tets of most passes are asked for nothing but that.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

#include "adapt/metric/vertex_metric.hpp"
#include "core/tets/tet_pairs.hpp"
#include "core/tets/tet_topology.hpp"

namespace tetloom::adapt {

/// Corners of the six edges of a tet; two that follow each other are opposite edges.
constexpr std::array<std::array<std::uint8_t, 2>, 6> kOppositeEdges{tets::kEdgeVerts[0], tets::kEdgeVerts[5],
                                                                    tets::kEdgeVerts[1], tets::kEdgeVerts[4],
                                                                    tets::kEdgeVerts[2], tets::kEdgeVerts[3]};

/// The squared lengths of a tet's edges, in the order of kOppositeEdges, in the metrics of both of their ends: the
/// smaller and the larger of them. The length of an edge lies between.
struct TetEdges {
  using Pair = tets::pairs::Pair;
  std::array<Pair, 3> lower, upper;

  double least() const {
    const Pair all = tets::pairs::min(lower[0], tets::pairs::min(lower[1], lower[2]));
    return std::min(all[0], all[1]);
  }
  double most() const {
    const Pair all = tets::pairs::max(upper[0], tets::pairs::max(upper[1], upper[2]));
    return std::max(all[0], all[1]);
  }
  double lower_of(std::size_t edge) const { return lower[edge / 2][edge % 2]; }
  double upper_of(std::size_t edge) const { return upper[edge / 2][edge % 2]; }
  double length_of(std::size_t edge) const {
    return logarithmic_mean(std::sqrt(lower_of(edge)), std::sqrt(upper_of(edge)));
  }
};

/// The edges of the tet with vertices `v`.
template <class Points, class Metrics>
TetEdges edges_of_tet(const Points& points, const Metrics& metrics, const std::uint32_t* v) {
  using tets::pairs::Pair;
  using tets::pairs::pair_of;
  TetEdges edges;
  for (std::size_t k = 0; k < 3; ++k) {
    const std::uint32_t a = v[kOppositeEdges[2 * k][0]], b = v[kOppositeEdges[2 * k][1]];
    const std::uint32_t c = v[kOppositeEdges[2 * k + 1][0]], d = v[kOppositeEdges[2 * k + 1][1]];
    const tets::pairs::PairVec e = pair_of(points[b], points[d]) - pair_of(points[a], points[c]);
    const Pair xx = e.x * e.x, yy = e.y * e.y, zz = e.z * e.z, xy = e.x * e.y, xz = e.x * e.z, yz = e.y * e.z;
    const auto squared = [&](const Tensor& m, const Tensor& n) {
      return Pair{m.xx, n.xx} * xx + Pair{m.yy, n.yy} * yy + Pair{m.zz, n.zz} * zz +
             2 * (Pair{m.xy, n.xy} * xy + Pair{m.xz, n.xz} * xz + Pair{m.yz, n.yz} * yz);
    };
    const Pair first = squared(metrics[a].tensor, metrics[c].tensor);
    const Pair second = squared(metrics[b].tensor, metrics[d].tensor);
    edges.lower[k] = tets::pairs::min(first, second), edges.upper[k] = tets::pairs::max(first, second);
  }
  return edges;
}

/// How many edges of tets, each as often as it has tets, have which lengths.
struct LengthCounts {
  std::int64_t unit = 0;         ///< in [1/√2, √2]
  std::int64_t half_to_two = 0;  ///< in [1/2, 2]

  void add(const TetEdges& edges) {
    if (edges.least() >= 0.5 && edges.most() <= 2) {
      unit += 6, half_to_two += 6;
      return;
    }
    for (std::size_t k = 0; k < 6; ++k) {
      const bool is_unit = edges.lower_of(k) >= 0.5 && edges.upper_of(k) <= 2;
      const double length = is_unit ? 1 : edges.length_of(k);
      unit += length >= std::sqrt(0.5) && length <= std::sqrt(2.0);
      half_to_two += length >= 0.5 && length <= 2;
    }
  }
};

}  // namespace tetloom::adapt
