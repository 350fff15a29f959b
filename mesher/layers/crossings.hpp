#pragma once
// Where layers would be in the way of each other or of something else.
#include <cstdint>
#include <span>
#include <vector>

#include "mesher/layers/layered_surface.hpp"
#include "tetloom/tasks.hpp"

namespace tetloom::layers {

/// What the exact test is made on.
struct LayersInQuestion {
  std::span<const FaceSides> face_to_sides;
  const Walls& walls;
  const SideFaces& sides;
  const LayerCounts& counts;
  const LayeredSurface& surface;
  /// Per curve, whether its count is another one since the last test, which found the rest embedded.
  std::span<const std::uint8_t> changed;
};

/// Per curve whether its layers are in the way: walls, tops, layers on curved side faces and all other surfaces of each
/// region by the exact test for self-intersections. None is in the way: all of them are embedded. Errors: Cancelled.
std::vector<std::uint8_t> find_curves_in_the_way(const LayersInQuestion& layers, const TaskRunner& runner);

}  // namespace tetloom::layers
