#include "adapt/metric/start_grid.hpp"

#include <algorithm>
#include <cmath>

#include "tetloom/ids.hpp"

namespace tetloom::adapt {

namespace {

constexpr std::size_t kTetsPerCell = 4;

Box3 box_around(const TetView& mesh) {
  Box3 box;
  for (const TetVerts& tet : mesh.tets)
    for (const std::uint32_t v : tet) box.add(mesh.points[v]);
  return box;
}

}  // namespace

StartGrid::StartGrid(const TetView& mesh) : box_(box_around(mesh)) {
  choose_cells(mesh.tets.size());
  for (std::uint32_t tet = 0; tet < mesh.tets.size(); ++tet) {
    const auto corner = [&](std::size_t i) { return mesh.points[mesh.tets[tet][i]]; };
    std::uint32_t& first = cell_to_tet_[cell_of(0.25 * ((corner(0) + corner(1)) + (corner(2) + corner(3))))];
    first = std::min(first, tet);
  }
  fill_empty_cells();
}

// Cubic cells, but no more than wanted of them where the box is flat or thin.
void StartGrid::choose_cells(std::size_t tet_count) {
  const Vec3 extent = box_.hi - box_.lo;
  const double wanted = std::max(1.0, static_cast<double>(tet_count) / kTetsPerCell);
  double edge = std::max({extent.x, extent.y, extent.z}) / wanted;
  const auto count_along = [&](int axis) { return edge > 0 ? std::max(1.0, std::floor(extent[axis] / edge)) : 1.0; };
  while (count_along(0) * count_along(1) * count_along(2) > wanted) edge *= 1.2;
  for (int axis = 0; axis < 3; ++axis)
    cells_[static_cast<std::size_t>(axis)] = static_cast<std::size_t>(count_along(axis));
  cell_to_tet_.assign(cells_[0] * cells_[1] * cells_[2], kNone);
}

std::size_t StartGrid::cell_of(const Vec3& x) const {
  std::size_t cell = 0;
  for (int axis = 2; axis >= 0; --axis) {
    const std::size_t n = cells_[static_cast<std::size_t>(axis)];
    const double extent = box_.hi[axis] - box_.lo[axis];
    const double at = extent > 0 ? (x[axis] - box_.lo[axis]) / extent * static_cast<double>(n) : 0;
    const double last = static_cast<double>(n - 1);
    cell = cell * n + static_cast<std::size_t>(std::clamp(at, 0.0, last));
  }
  return cell;
}

// Cells name the first tet whose centre lies in them; cells without one take over that of the cell before or behind,
// along x, then y, then z, so that the tet is near.
void StartGrid::fill_empty_cells() {
  std::size_t stride = 1;
  for (const std::size_t n : cells_) {
    for (std::size_t i = 0; i < cell_to_tet_.size(); ++i)
      if (cell_to_tet_[i] == kNone && i / stride % n > 0) cell_to_tet_[i] = cell_to_tet_[i - stride];
    for (std::size_t i = cell_to_tet_.size(); i-- > 0;)
      if (cell_to_tet_[i] == kNone && i / stride % n + 1 < n) cell_to_tet_[i] = cell_to_tet_[i + stride];
    stride *= n;
  }
}

}  // namespace tetloom::adapt
