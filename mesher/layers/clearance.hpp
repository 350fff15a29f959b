#pragma once
// How much room there is above a wall.
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "mesher/intersection/triangle_tree.hpp"
#include "tetloom/model.hpp"
#include "tetloom/tasks.hpp"

namespace tetloom::layers {

/// What a growth curve sees opposite to it.
struct Clearance {
  double distance = HUGE_VAL;  ///< infinite where nothing is in reach
  bool has_layers = false;     ///< the opposite triangle is a wall of the same region
};

/// What is looked at: triangles with the regions on their sides. Refers to all of it.
struct OppositeSurface {
  std::span<const FaceSides> tri_to_sides;
  std::span<const std::uint8_t> has_layers;  ///< per side of a triangle, 2 · triangle + is_front
  const intersection::TriangleTree& tree;    ///< of these triangles
  /// Whether the triangle is too near to where the look of this number starts to be opposite to it.
  std::function<bool(std::size_t look, std::uint32_t triangle)> is_beside;
};

/// From where, and how far.
struct LookAhead {
  std::uint32_t region = 0;
  Vec3 point;
  Vec3 direction;  ///< of length 1; zero: nothing is looked for
  double reach = 0;
};

/// For each the nearest triangle of its region within a cone of 25 degrees about its direction that faces it, as far as
/// its reach; of those off the direction, where it would meet their plane, if that is farther away. Errors: Cancelled.
std::vector<Clearance> find_clearances(const OppositeSurface& surface, std::span<const LookAhead> looks,
                                       const TaskRunner& runner);

}  // namespace tetloom::layers
