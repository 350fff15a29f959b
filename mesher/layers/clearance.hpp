#pragma once
// How much room there is above a wall.
#include <span>
#include <vector>

#include "mesher/intersection/triangle_tree.hpp"
#include "mesher/layers/walls.hpp"
#include "tetloom/tasks.hpp"

namespace tetloom::layers {

/// What a growth curve sees opposite to it.
struct Clearance {
  double distance = HUGE_VAL;  ///< infinite where nothing is in reach
  bool has_layers = false;     ///< the opposite triangle is a wall of the same region
};

/// For every curve the nearest triangle of its region within a cone of 25 degrees about its direction that faces it,
/// as far as `reach`, which is per curve; of those beside the direction, where it would meet their plane, if that is
/// farther away. Errors: Cancelled.
std::vector<Clearance> find_clearances(const Mesh& mesh, std::span<const FaceSides> face_to_sides, const Walls& walls,
                                       const intersection::TriangleTree& tree, std::span<const Vec3> directions,
                                       std::span<const double> reach, const TaskRunner& runner);

}  // namespace tetloom::layers
