#pragma once
// The cells of stacks, on wall triangles and on elements of fans, in points of growth curves.
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <tuple>
#include <type_traits>
#include <utility>

#include "mesher/layers/layer_cells.hpp"
#include "mesher/layers/walls.hpp"

namespace tetloom::layers {

/// A point of a growth curve, where level 0 is the foot; or the apex of a stack, which no curve has.
struct CurveLevel {
  std::uint32_t curve = 0;
  int level = 0;

  bool is_apex() const { return curve == kNone; }
};

/// The order by which cells are split: all quadrilaterals are cut from the vertex that comes first. Curves of one foot
/// have the same level 0.
inline bool comes_before(const Walls& walls, const CurveLevel& a, const CurveLevel& b) {
  const auto key = [&](const CurveLevel& at) {
    return std::pair(at.level, at.level == 0 ? walls.first_at_foot(at.curve) : at.curve);
  };
  return key(a) < key(b);
}

/// Calls visit(tet) for positive tets that a positive cell is split into, from its first vertex (Dompierre et al.
/// 1999).
template <std::size_t N, class Visit>
void split_cell(const Walls& walls, const std::array<CurveLevel, N>& cell, const Visit& visit) {
  if constexpr (N == 4) {
    visit(cell);
  } else {
    const auto first_of = [&](const auto& vertices) {
      return *std::ranges::min_element(
          vertices, [&](std::uint8_t i, std::uint8_t k) { return comes_before(walls, cell[i], cell[k]); });
    };
    std::array<std::uint8_t, N> all;
    for (std::uint8_t i = 0; i < N; ++i) all[i] = i;
    const std::uint8_t apex = first_of(all);
    for (const LocalFace& face : shape_of(kind_of_cell(N)).faces()) {
      const auto verts = face.vertices();
      if (std::ranges::count(verts, apex) > 0) continue;
      const auto start = static_cast<std::size_t>(std::ranges::find(verts, first_of(verts)) - verts.begin());
      const auto at = [&](std::size_t i) { return cell[verts[(start + i) % verts.size()]]; };
      for (std::size_t i = 1; i + 1 < verts.size(); ++i)
        visit(std::array<CurveLevel, 4>{at(0), at(i + 1), at(i), cell[apex]});
    }
  }
}

/// Calls visit(element) for what lies between two curves, from below: quadrilaterals {a, b, above b, above a}, and
/// triangles, both counter-clockwise seen from where a is left of b.
template <class Counts, class Visit>
void for_each_between(const Walls& walls, const Counts& counts, const std::array<std::uint32_t, 2>& curves,
                      const Visit& visit) {
  const auto [a, b] = curves;
  std::array<int, 2> low{};
  const auto grow = [&](bool grows_a, bool grows_b) {
    const CurveLevel at_a{a, low[0]}, at_b{b, low[1]}, above_a{a, low[0] + 1}, above_b{b, low[1] + 1};
    if (grows_a && grows_b) {
      visit(std::array{at_a, at_b, above_b, above_a});
    } else if (grows_a || grows_b) {
      visit(std::array{at_a, at_b, grows_a ? above_a : above_b});
    }
    low[0] += grows_a, low[1] += grows_b;
  };
  const bool late_a = walls.curve_is_late[a] != 0, late_b = walls.curve_is_late[b] != 0;
  const int count_a = counts.count(a), count_b = counts.count(b);
  grow(count_a > 0 && !late_a, count_b > 0 && !late_b);
  grow(count_a > 0 && late_a, count_b > 0 && late_b);
  for (int level = 1; level < std::max(count_a, count_b); ++level) grow(count_a > level, count_b > level);
}

namespace detail {

template <class CountOf, class Visit>
void for_each_cell_on_triangle(const Walls& walls, const std::array<std::uint32_t, 3>& curves, const CountOf& count_of,
                               const Visit& visit) {
  std::array<int, 3> counts;
  std::array<bool, 3> late;
  for (std::size_t i = 0; i < 3; ++i) counts[i] = count_of(curves[i]), late[i] = walls.curve_is_late[curves[i]] != 0;
  for_each_cell(counts, late, [&](CellKind, const auto& corners) {
    std::array<CurveLevel, std::tuple_size_v<std::decay_t<decltype(corners)>>> cell;
    int layer = 0;
    for (std::size_t i = 0; i < cell.size(); ++i) {
      cell[i] = {curves[corners[i].corner], corners[i].level};
      layer = std::max(layer, cell[i].level);
    }
    visit(cell, layer);
  });
}

/// On the edge p–q, of curves a and b at p, c and d at q: prisms about the edge, hexahedra above them, lying prisms
/// where one end has more layers, and a pyramid on top.
template <class CountOf, class Visit>
void for_each_cell_on_edge(std::array<std::uint32_t, 4> curves, const CountOf& count_of, const Visit& visit) {
  if (count_of(curves[0]) > count_of(curves[2])) std::ranges::rotate(curves, curves.begin() + 2);
  const auto [a, b, c, d] = curves;
  const int low = count_of(a), high = count_of(c);
  const auto quad = [&](int level) {
    const int at_p = std::min(level, low);
    return std::array<CurveLevel, 4>{{{a, at_p}, {b, at_p}, {c, level}, {d, level}}};
  };
  for (int level = 0; level < high; ++level) {
    const int up = level + 1;
    const auto [la, lb, lc, ld] = quad(level);
    const auto [ua, ub, uc, ud] = quad(up);
    if (up <= low && level == 0) {
      visit(std::array{la, ua, ub, ld, ud, uc}, up);
    } else if (up <= low) {
      visit(std::array{la, lb, lc, ld, ua, ub, uc, ud}, up);
    } else if (low > 0) {
      visit(std::array{la, ld, ud, lb, lc, uc}, up);
    } else if (level > 0) {
      visit(std::array{ld, lc, uc, ud, la}, up);
    } else {
      visit(std::array{ld, uc, ud, la}, up);
    }
  }
  if (low == 0) return;
  const auto [ta, tb, tc, td] = quad(high);
  visit(std::array{ta, tb, tc, td, CurveLevel{kNone, high + 1}}, high + 1);
}

/// Cells of the first layer lose what has no extent.
template <class CountOf, class Visit>
void for_each_cell_on_fan(const Walls& walls, const FanElement& fan, const CountOf& count_of, const Visit& visit) {
  if (fan.kind == FanElement::Kind::Quad) return for_each_cell_on_edge(fan.curves, count_of, visit);
  if (count_of(fan.curves[1]) == 0) return;
  const std::array<std::uint32_t, 3> curves{fan.curves[0], fan.curves[1], fan.curves[2]};
  for_each_cell_on_triangle(walls, curves, count_of, [&](const auto& cell, int layer) {
    constexpr std::size_t kVertices = std::tuple_size_v<std::decay_t<decltype(cell)>>;
    if constexpr (kVertices == 6) {
      if (layer == 1) return visit(std::array{cell[0], cell[3], cell[4], cell[5]}, layer);
    } else if constexpr (kVertices == 5) {
      if (layer == 1) return visit(std::array{cell[0], cell[1], cell[2], cell[4]}, layer);
    }
    visit(cell, layer);
  });
}

}  // namespace detail

/// Calls visit(cell, layer) for the cells of a stack whose curves have count_of(curve) layers, from the wall upwards.
template <class CountOf, class Visit>
void for_each_cell_on(const Walls& walls, std::size_t stack, const CountOf& count_of, const Visit& visit) {
  if (walls.is_fan(stack)) {
    detail::for_each_cell_on_fan(walls, walls.fan(stack), count_of, visit);
  } else {
    detail::for_each_cell_on_triangle(walls, walls.triangles[stack].curves, count_of, visit);
  }
}

}  // namespace tetloom::layers
