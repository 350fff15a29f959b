#pragma once
// The elements of boundary layers as meshes have them: the cells of stacks, whole or split into tets, and what stands
// on side faces. Vertices are named by curve and level.
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <utility>

#include "mesher/layers/grow_layers.hpp"
#include "mesher/layers/layer_cells.hpp"

namespace tetloom::layers {

/// A point of a growth curve; level 0 is the foot.
struct CurveLevel {
  std::uint32_t curve = 0;
  int level = 0;
};

/// The vertices of a curve, however they are numbered: those between foot and top follow each other.
struct CurveVertices {
  std::uint32_t foot = kNone, top = kNone;
  std::uint32_t first_level = 0;  ///< of level 1
};

/// The vertices of one stack.
class StackVertices {
 public:
  /// vertices_of(curve): its CurveVertices.
  template <class VerticesOf>
  StackVertices(const LayerCounts& counts, const WallTriangle& wall, const VerticesOf& vertices_of)
      : curves_(wall.curves) {
    for (std::size_t i = 0; i < 3; ++i) {
      counts_[i] = counts.count(curves_[i]);
      vertices_[i] = vertices_of(curves_[i]);
    }
  }
  /// Pre: on one of the stack's curves.
  std::uint32_t at(const CurveLevel& place) const {
    const std::size_t i = place.curve == curves_[0] ? 0 : place.curve == curves_[1] ? 1 : 2;
    if (place.level == 0) return vertices_[i].foot;
    if (place.level == counts_[i]) return vertices_[i].top;
    return vertices_[i].first_level + static_cast<std::uint32_t>(place.level) - 1;
  }
  template <std::size_t N>
  std::array<std::uint32_t, N> at(const std::array<CurveLevel, N>& places) const {
    std::array<std::uint32_t, N> verts;
    for (std::size_t i = 0; i < N; ++i) verts[i] = at(places[i]);
    return verts;
  }

 private:
  std::array<std::uint32_t, 3> curves_;
  std::array<int, 3> counts_{};
  std::array<CurveVertices, 3> vertices_;
};

namespace detail {

using CurveTet = std::array<CurveLevel, 4>;

/// Of a quadrilateral between two curves, the diagonal starts below at the curve of lower number. Even permutations of
/// the curves keep a tet positive, odd ones are mended by a swap.
template <class Visit>
void split_cell(const std::array<CurveLevel, 6>& prism, const Visit& visit) {
  std::array<std::size_t, 3> order{0, 1, 2};
  std::ranges::sort(order, {}, [&](std::size_t i) { return prism[i].curve; });
  const bool is_even = (order[1] + 3 - order[0]) % 3 == 1;
  const auto low = [&](std::size_t i) { return prism[order[i]]; };
  const auto high = [&](std::size_t i) { return prism[order[i] + 3]; };
  for (CurveTet tet : {CurveTet{low(0), low(1), low(2), high(2)}, CurveTet{low(0), low(1), high(2), high(1)},
                       CurveTet{low(0), high(1), high(2), high(0)}}) {
    if (!is_even) std::swap(tet[1], tet[2]);
    visit(tet);
  }
}

/// 0 is below 1 on one curve, 3 below 2 on the other.
template <class Visit>
void split_cell(const std::array<CurveLevel, 5>& pyramid, const Visit& visit) {
  const auto& [a, b, c, d, apex] = pyramid;
  if (a.curve < d.curve) {
    visit(CurveTet{a, b, c, apex});
    visit(CurveTet{a, c, d, apex});
  } else {
    visit(CurveTet{a, b, d, apex});
    visit(CurveTet{b, c, d, apex});
  }
}

template <class Visit>
void split_cell(const CurveTet& tet, const Visit& visit) {
  visit(tet);
}

}  // namespace detail

/// Calls visit(vertices, layer) for the cells above a wall triangle, from the wall upwards; layer 1 stands on the wall.
/// The kind of cell follows from the number of vertices. With `all_tets` they are tets.
template <class Visit>
void for_each_stack_cell(const LayerGrowth& growth, const WallTriangle& wall, bool all_tets, const Visit& visit) {
  std::array<int, 3> counts;
  for (std::size_t i = 0; i < 3; ++i) counts[i] = growth.counts().count(wall.curves[i]);
  int layer = 0;
  for_each_cell(counts, [&](CellKind, const auto& corners) {
    std::array<CurveLevel, std::tuple_size_v<std::decay_t<decltype(corners)>>> verts;
    for (std::size_t i = 0; i < verts.size(); ++i) verts[i] = {wall.curves[corners[i].corner], corners[i].level};
    ++layer;
    if (all_tets) {
      detail::split_cell(verts, [&](const detail::CurveTet& tet) { visit(tet, layer); });
    } else {
      visit(verts, layer);
    }
  });
}

constexpr CellKind kind_of_cell(std::size_t vertices) {
  return vertices == 4   ? CellKind::Tet
         : vertices == 5 ? CellKind::Pyramid
         : vertices == 6 ? CellKind::Prism
                         : CellKind::Hex;
}

/// The height of a layer above a wall triangle: the mean way from one level to the next, along curves that have it.
inline double height_of_layer(const LayerCounts& counts, const WallTriangle& wall, int layer) {
  double sum = 0;
  int grown = 0;
  for (const std::uint32_t c : wall.curves) {
    if (counts.count(c) < layer) continue;
    sum += distance(counts.point(c, layer - 1), counts.point(c, layer));
    ++grown;
  }
  return sum / grown;
}

/// Calls visit(vertices) for the quadrilaterals, and triangles, of layers on the side face at a piece of rim; seen as
/// those of a mesh. With `all_tets` they are triangles.
template <class Visit>
void for_each_side_element(const LayerGrowth& growth, const WallRim& rim, bool all_tets, const Visit& visit) {
  using Triangle = std::array<CurveLevel, 3>;
  using Quad = std::array<CurveLevel, 4>;
  const LayerCounts& counts = growth.counts();
  const WallTriangle& wall = growth.walls().triangles[rim.wall];
  const std::uint32_t c = wall.curves[rim.corner], d = wall.curves[(rim.corner + 1) % 3];
  const bool is_outward = growth.model().topology().face_to_sides[rim.side_face].back.value == wall.region;
  const auto add_triangle = [&](Triangle verts) {
    if (!is_outward) std::swap(verts[1], verts[2]);
    visit(verts);
  };
  const int both = std::min(counts.count(c), counts.count(d)), most = std::max(counts.count(c), counts.count(d));
  for (int level = 0; level < both; ++level) {
    Quad quad{CurveLevel{c, level}, {d, level}, {d, level + 1}, {c, level + 1}};
    const auto& [a, b, above_b, above_a] = quad;
    if (!all_tets) {
      if (!is_outward) std::swap(quad[1], quad[3]);
      visit(quad);
    } else if (c < d) {
      add_triangle({a, b, above_b});
      add_triangle({a, above_b, above_a});
    } else {
      add_triangle({a, b, above_a});
      add_triangle({b, above_b, above_a});
    }
  }
  for (int level = both; level < most; ++level)
    add_triangle({CurveLevel{c, std::min(level, counts.count(c))}, CurveLevel{d, std::min(level, counts.count(d))},
                  CurveLevel{counts.count(c) > level ? c : d, level + 1}});
}

/// Calls visit(lower, upper) for the pieces of model edges that layers stand on.
template <class Visit>
void for_each_layer_edge(const LayerGrowth& growth, std::uint32_t curve, const Visit& visit) {
  if (!growth.sides().is_along_edge(curve)) return;
  for (int level = 0; level < growth.counts().count(curve); ++level)
    visit(CurveLevel{curve, level}, CurveLevel{curve, level + 1});
}

}  // namespace tetloom::layers
