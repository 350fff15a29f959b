#pragma once
// The cells above one wall triangle: prisms, then pyramids, then tets, as its three growth curves end one by one.
#include <algorithm>
#include <array>
#include <cstdint>

#include "tetloom/mesh_data.hpp"
#include "tetloom/vec.hpp"

namespace tetloom::layers {

/// A place on the growth curve at corner `corner` of a wall triangle; level 0 is on the wall.
struct LevelCorner {
  std::uint8_t corner;
  int level;
};

/// Calls visit(kind, corners) for the cells of one wall triangle whose curves have so many layers, from the wall
/// upwards; `corners` are the vertices of a positive cell. A quadrilateral between two curves belongs to the cells of
/// both triangles beside it, so that the cells of neighbours fit.
template <class Visit>
void for_each_cell(const std::array<int, 3>& counts, const Visit& visit) {
  const int top = *std::max_element(counts.begin(), counts.end());
  for (int level = 0; level < top; ++level) {
    const auto at = [&](int corner, int l) {
      return LevelCorner{static_cast<std::uint8_t>(corner), std::min(l, counts[static_cast<std::size_t>(corner)])};
    };
    const auto grows = [&](int corner) { return counts[static_cast<std::size_t>(corner)] > level; };
    const int growing = grows(0) + grows(1) + grows(2), up = level + 1;
    if (growing == 3) {
      visit(CellKind::Prism, std::array{at(0, level), at(1, level), at(2, level), at(0, up), at(1, up), at(2, up)});
    } else if (growing == 2) {
      const int apex = !grows(0) ? 0 : !grows(1) ? 1 : 2, j = (apex + 1) % 3, l = (apex + 2) % 3;
      visit(CellKind::Pyramid, std::array{at(j, level), at(j, up), at(l, up), at(l, level), at(apex, up)});
    } else {
      const int i = grows(0) ? 0 : grows(1) ? 1 : 2, j = (i + 1) % 3, l = (i + 2) % 3;
      visit(CellKind::Tet, std::array{at(i, level), at(j, up), at(l, up), at(i, up)});
    }
  }
}

/// Whether all tets of all ways to split the cell are positive, in exact arithmetic: 12 of a prism, 4 of a pyramid. All
/// finer splits, and the cell itself with flat or curved quadrilaterals in between, are free of folds then.
bool is_positive(const std::array<Vec3, 6>& prism);
bool is_positive(const std::array<Vec3, 5>& pyramid);
bool is_positive(const std::array<Vec3, 4>& tet);

/// The least over the corners of the Jacobian, divided by the lengths of the three edges there; 1 for the prism that
/// stands on an equilateral triangle. Of a tet, the corner of vertex 0 alone, where the edge between layers starts.
double scaled_jacobian(const std::array<Vec3, 6>& prism);
double scaled_jacobian(const std::array<Vec3, 5>& pyramid);
double scaled_jacobian(const std::array<Vec3, 4>& tet);

/// Whether the cell is positive and its scaled Jacobian is at least so much. Pre: least >= 1e-6, so that corners of
/// that Jacobian are positive for certain.
bool is_sound(const std::array<Vec3, 6>& prism, double least);
bool is_sound(const std::array<Vec3, 5>& pyramid, double least);
bool is_sound(const std::array<Vec3, 4>& tet, double least);

}  // namespace tetloom::layers
