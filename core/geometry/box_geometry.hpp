#pragma once
// A box as edges and faces of a model.
#include <array>
#include <cstdint>
#include <memory>
#include <utility>

#include "tetloom/model.hpp"

namespace tetloom {

inline constexpr int kBoxCorners = 8, kBoxEdges = 12, kBoxSides = 6;

/// Bit i of `corner` says whether it lies above along axis i.
Vec3 corner_of(const Box3& box, int corner);

/// The corners of an edge; four along each axis.
struct BoxEdge {
  int from = 0, to = 0;
};
BoxEdge edge_of_box(int edge);

/// Side 2 · axis + (0 below, 1 above), with its normal out of the box and (u,v) as lengths along two axes.
struct BoxSide {
  int axis, u, v;
  bool above;

  explicit BoxSide(int side) : axis(side / 2), u((axis + 1) % 3), v((axis + 2) % 3), above(side % 2 == 1) {
    if (!above) std::swap(u, v);
  }
  /// Counter-clockwise seen from outside.
  std::array<int, 4> corners() const {
    const int base = above ? 1 << axis : 0;
    return {base, base | (1 << u), base | (1 << u) | (1 << v), base | (1 << v)};
  }
};

/// An edge of the box, over its length.
std::unique_ptr<EdgeGeometry> edge_geometry_of(const Box3& box, int edge);
/// A side of the box. In the model, edges and corners of the box have the numbers from `first_edge` and `first_vertex`
/// on.
std::unique_ptr<FaceGeometry> face_geometry_of(const Box3& box, int side, std::uint32_t first_edge,
                                               std::uint32_t first_vertex);

}  // namespace tetloom
