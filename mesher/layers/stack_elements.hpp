#pragma once
// The elements of boundary layers as meshes have them: the cells of stacks, whole or split into tets, and what stands
// on side faces. Vertices are named by curve and level.
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>

#include "mesher/layers/grow_layers.hpp"
#include "mesher/layers/stack_cells.hpp"

namespace tetloom::layers {

/// The vertices of a curve, however they are numbered: those between foot and top follow each other.
struct CurveVertices {
  std::uint32_t foot = kNone, top = kNone;
  std::uint32_t first_level = 0;  ///< of level 1
};

/// The vertices of one stack.
class StackVertices {
 public:
  /// vertices_of(curve): its CurveVertices. `apex` is none where the stack has none.
  template <class VerticesOf>
  StackVertices(const LayerGrowth& growth, std::uint32_t stack, std::uint32_t apex, const VerticesOf& vertices_of)
      : curves_(growth.walls().curves_of(stack)), apex_(apex) {
    for (std::size_t i = 0; i < curves_.size(); ++i) {
      counts_[i] = growth.counts().count(curves_[i]);
      vertices_[i] = vertices_of(curves_[i]);
    }
  }
  /// Pre: on one of the stack's curves, or its apex.
  std::uint32_t at(const CurveLevel& place) const {
    if (place.is_apex()) return apex_;
    const auto i = static_cast<std::size_t>(std::ranges::find(curves_, place.curve) - curves_.begin());
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
  std::span<const std::uint32_t> curves_;
  std::uint32_t apex_;
  std::array<int, 4> counts_{};
  std::array<CurveVertices, 4> vertices_;
};

/// Calls visit(vertices, layer) for the cells of a stack, from the wall upwards; layer 1 stands on the wall. The kind
/// of cell follows from the number of vertices. With `all_tets` they are tets.
template <class Visit>
void for_each_stack_cell(const LayerGrowth& growth, std::uint32_t stack, bool all_tets, const Visit& visit) {
  const Walls& walls = growth.walls();
  const auto count_of = [&](std::uint32_t c) { return growth.counts().count(c); };
  for_each_cell_on(walls, stack, count_of, [&](const auto& cell, int layer) {
    if (all_tets) {
      split_cell(walls, cell, [&](const std::array<CurveLevel, 4>& tet) { visit(tet, layer); });
    } else {
      visit(cell, layer);
    }
  });
}

/// The height of a layer of a stack: the mean way from one level to the next, along curves that have it. That of an
/// apex is the one of the layer below it.
inline double height_of_layer(const LayerGrowth& growth, std::uint32_t stack, int layer) {
  const LayerCounts& counts = growth.counts();
  double sum = 0;
  int grown = 0;
  for (const std::uint32_t c : growth.walls().curves_of(stack)) {
    if (counts.count(c) < layer) continue;
    sum += distance(counts.point(c, layer - 1), counts.point(c, layer));
    ++grown;
  }
  return grown > 0 ? sum / grown : height_of_layer(growth, stack, layer - 1);
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
  for_each_between(growth.walls(), counts, {c, d}, [&](const auto& element) {
    if constexpr (std::tuple_size_v<std::decay_t<decltype(element)>> == 3) {
      add_triangle(element);
    } else {
      const auto& [a, b, above_b, above_a] = element;
      if (!all_tets) {
        visit(is_outward ? element : Quad{a, above_a, above_b, b});
      } else if (comes_before(growth.walls(), a, b)) {
        add_triangle({a, b, above_b});
        add_triangle({a, above_b, above_a});
      } else {
        add_triangle({a, b, above_a});
        add_triangle({b, above_b, above_a});
      }
    }
  });
}

/// Calls visit(lower, upper) for the pieces of model edges that layers stand on.
template <class Visit>
void for_each_layer_edge(const LayerGrowth& growth, std::uint32_t curve, const Visit& visit) {
  if (!growth.sides().is_along_edge(curve)) return;
  for (int level = 0; level < growth.counts().count(curve); ++level)
    visit(CurveLevel{curve, level}, CurveLevel{curve, level + 1});
}

}  // namespace tetloom::layers
