#include "core/mesh/cell_jacobians.hpp"

#include <algorithm>
#include <cmath>
#include <span>
#include <vector>

#include "core/base/grain.hpp"
#include "core/mesh/mesh_access.hpp"
#include "core/mesh/statistics_detail.hpp"

namespace tetloom {
namespace {

constexpr double kOfEquilateral = 0.8660254037844386;

template <class Cell>
double least_of(const Cell& cell, CellKind kind, const std::vector<Vec3>& points) {
  double least = 1;
  const double best = kind == CellKind::Prism ? kOfEquilateral : 1;
  for (const auto& [o, a, b, c] : corners_of(kind)) {
    const Vec3 &x = points[cell[o]], u = points[cell[a]] - x, v = points[cell[b]] - x, w = points[cell[c]] - x;
    const double lengths = norm(u) * norm(v) * norm(w), jacobian = dot(cross(u, v), w) / (lengths * best);
    least = std::min(least, lengths > 0 && std::isfinite(jacobian) ? jacobian : 0);
  }
  return least;
}

}  // namespace

CellJacobians measure_jacobians(const Mesh& mesh, const BlockLoop& loop, GrowingArray<float>& values) {
  values.clear();
  for_each_cell_kind(mesh, [&](CellKind kind, const auto& cells, const auto&) {
    if (kind == CellKind::Tet || cells.empty()) return;
    const std::size_t first = values.size();
    values.resize_for_overwrite(first + cells.size());
    loop.for_blocks(cells.size(), kCopyGrain, [&](std::size_t begin, std::size_t end) {
      for (std::size_t c = begin; c < end; ++c)
        values[first + c] = static_cast<float>(least_of(cells[c], kind, mesh.points));
    });
  });
  if (values.empty()) return {};
  return {*std::ranges::min_element(values), detail::quantile(values.span(), 0.01, loop)};
}

}  // namespace tetloom
