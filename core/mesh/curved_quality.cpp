#include "core/mesh/curved_quality.hpp"

#include <algorithm>
#include <span>
#include <vector>

#include "core/base/grain.hpp"
#include "core/mesh/curved_cell.hpp"
#include "core/mesh/curved_tet.hpp"
#include "core/mesh/mesh_access.hpp"
#include "core/mesh/statistics_detail.hpp"
#include "core/mesh/tet_volume.hpp"

namespace tetloom {
namespace {

using detail::Sum;

struct CurvedSums {
  std::size_t count = 0, not_positive = 0;
  double least = 1;
  Sum volume;

  void add(const CurvedSums& other) {
    count += other.count, not_positive += other.not_positive;
    least = std::min(least, other.least);
    volume.add(other.volume);
  }
};

CurvedSums measure_curved_tets(const Mesh& mesh, const MidNodes& mids, std::span<const std::uint8_t> is_end,
                               const BlockLoop& loop) {
  const auto measure = [&](std::size_t begin, std::size_t end, CurvedSums& sums) {
    for (std::size_t t = begin; t < end; ++t) {
      const auto& [a, b, c, d] = mesh.tet_to_vert[t];
      const double volume = tet_volume(mesh.points[a], mesh.points[b], mesh.points[c], mesh.points[d]);
      const bool is_straight = !has_two_of(mesh.tet_to_vert[t], is_end) || is_straight_tet(mesh, mids, t);
      const TetJacobian jacobian = is_straight ? TetJacobian{} : tet_jacobian(nodes_of_tet(mesh, mids, t));
      sums.volume.add(is_straight ? volume : volume * mean_jacobian(jacobian));
      if (is_straight) continue;
      ++sums.count;
      sums.least = std::min(sums.least, least_jacobian(jacobian, sums.least));
      if (!has_positive_jacobian(mesh, mids, t)) ++sums.not_positive;
    }
  };
  CurvedSums total;
  for (const CurvedSums& sums : map_blocks(loop, mesh.tet_to_vert.size(), kCopyGrain, CurvedSums{}, measure))
    total.add(sums);
  return total;
}

CurvedSums measure_curved_cells(const Mesh& mesh, const MidNodes& mids, const BlockLoop& loop) {
  CurvedSums total;
  for_each_cell_kind(mesh, [&](CellKind kind, const auto& cells, const auto&) {
    if (kind == CellKind::Tet) return;
    const auto measure = [&](std::size_t begin, std::size_t end, CurvedSums& sums) {
      for (std::size_t c = begin; c < end; ++c) {
        const CurvedCell cell = curved_cell_of(mesh, mids, kind, cells[c]);
        const CellJacobian jacobian = cell_jacobian(cell);
        sums.volume.add(jacobian.volume);
        if (cell.is_straight()) continue;
        ++sums.count;
        sums.least = std::min(sums.least, least_jacobian(jacobian, sums.least));
        if (!has_positive_jacobian(jacobian)) ++sums.not_positive;
      }
    };
    for (const CurvedSums& sums : map_blocks(loop, cells.size(), kCopyGrain, CurvedSums{}, measure)) total.add(sums);
  });
  return total;
}

}  // namespace

CurvedQuality measure_curved(const Mesh& mesh, double straight_volume, const BlockLoop& loop) {
  if (mesh.mid_to_vert.empty()) return {0, 0, 1, straight_volume};
  const MidNodes mids(mesh);
  CurvedSums total = measure_curved_tets(mesh, mids, ends_of_bent_edges(mesh), loop);
  total.add(measure_curved_cells(mesh, mids, loop));
  return {total.count, total.not_positive, total.least, total.volume.value()};
}

}  // namespace tetloom
