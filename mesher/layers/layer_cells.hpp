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

constexpr CellKind kind_of_cell(std::size_t vertices) {
  return vertices == 4   ? CellKind::Tet
         : vertices == 5 ? CellKind::Pyramid
         : vertices == 6 ? CellKind::Prism
                         : CellKind::Hex;
}

namespace detail {

/// The cell between a front of three corners at levels `low` and the next one, where some of them grow by a level.
template <class Visit>
void visit_cell(const std::array<int, 3>& low, const std::array<bool, 3>& grows, const Visit& visit) {
  const auto at = [&](std::size_t corner, bool up) {
    return LevelCorner{static_cast<std::uint8_t>(corner), low[corner] + (up && grows[corner])};
  };
  const int growing = grows[0] + grows[1] + grows[2];
  if (growing == 3) {
    visit(CellKind::Prism, std::array{at(0, false), at(1, false), at(2, false), at(0, true), at(1, true), at(2, true)});
  } else if (growing == 2) {
    const std::size_t apex = !grows[0] ? 0 : !grows[1] ? 1 : 2, j = (apex + 1) % 3, l = (apex + 2) % 3;
    visit(CellKind::Pyramid, std::array{at(j, false), at(j, true), at(l, true), at(l, false), at(apex, true)});
  } else if (growing == 1) {
    const std::size_t i = grows[0] ? 0 : grows[1] ? 1 : 2, j = (i + 1) % 3, l = (i + 2) % 3;
    visit(CellKind::Tet, std::array{at(i, false), at(j, true), at(l, true), at(i, true)});
  }
}

}  // namespace detail

/// Calls visit(kind, corners) for the cells of one wall triangle whose curves have so many layers, from the wall
/// upwards; `corners` are the vertices of a positive cell. A quadrilateral between two curves belongs to the cells of
/// both triangles beside it, so that the cells of neighbours fit. In the first layer, curves that are `late` grow after
/// the others: between one of each kind there are two triangles instead of a quadrilateral, cut from the late one's
/// foot.
template <class Visit>
void for_each_cell(const std::array<int, 3>& counts, const std::array<bool, 3>& late, const Visit& visit) {
  std::array<int, 3> low{};
  const auto grow = [&](const auto& may_grow) {
    std::array<bool, 3> grows;
    for (std::size_t i = 0; i < 3; ++i) grows[i] = may_grow(i);
    detail::visit_cell(low, grows, visit);
    for (std::size_t i = 0; i < 3; ++i) low[i] += grows[i];
  };
  grow([&](std::size_t i) { return counts[i] > 0 && !late[i]; });
  grow([&](std::size_t i) { return counts[i] > 0 && late[i]; });
  for (int level = 1; level < std::ranges::max(counts); ++level) grow([&](std::size_t i) { return counts[i] > level; });
}
template <class Visit>
void for_each_cell(const std::array<int, 3>& counts, const Visit& visit) {
  for_each_cell(counts, {false, false, false}, visit);
}

/// Whether all tets of all ways to split the cell are positive, in exact arithmetic: 12 of a prism, 4 of a pyramid, and
/// of a hexahedron those of the prisms on halves of its first face and of the one opposite to it, cut alike. All finer
/// splits, and the cell itself with flat or curved quadrilaterals in between, are free of folds then.
bool is_positive(const std::array<Vec3, 8>& hex);
bool is_positive(const std::array<Vec3, 6>& prism);
bool is_positive(const std::array<Vec3, 5>& pyramid);
bool is_positive(const std::array<Vec3, 4>& tet);

/// The least over the corners of the Jacobian, divided by the lengths of the three edges there; 1 for the prism that
/// stands on an equilateral triangle, and for the cube. Of a tet, the corner of vertex 0 alone, where the edge between
/// layers starts.
double scaled_jacobian(const std::array<Vec3, 8>& hex);
double scaled_jacobian(const std::array<Vec3, 6>& prism);
double scaled_jacobian(const std::array<Vec3, 5>& pyramid);
double scaled_jacobian(const std::array<Vec3, 4>& tet);

/// Whether the cell is positive and its scaled Jacobian is at least so much. Pre: least >= 1e-6, so that corners of
/// that Jacobian are positive for certain.
bool is_sound(const std::array<Vec3, 8>& hex, double least);
bool is_sound(const std::array<Vec3, 6>& prism, double least);
bool is_sound(const std::array<Vec3, 5>& pyramid, double least);
bool is_sound(const std::array<Vec3, 4>& tet, double least);

}  // namespace tetloom::layers
