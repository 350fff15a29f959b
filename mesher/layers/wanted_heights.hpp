#pragma once
// How high layers are to become, before it is tried.
#include <span>
#include <vector>

#include "mesher/layers/side_faces.hpp"
#include "mesher/layers/walls.hpp"
#include "tetloom/tasks.hpp"

namespace tetloom::layers {

/// Where the growth curves of some walls start.
struct CurveStarts {
  const Mesh& mesh;
  std::span<const FaceSides> face_to_sides;
  const Walls& walls;
  const SideFaces& sides;
  std::span<const Vec3> directions;  ///< per curve, of length 1; zero where it cannot grow
  std::span<const double> stretch;   ///< per curve: length over height
};

/// Per curve: the height of its layers together, 0 where it cannot grow, and why that is less than what was asked for.
struct WantedHeights {
  std::vector<double> heights;
  std::vector<LayerLimit> limits;
};

/// Heights as asked for, or less: no layer but the first is higher than its triangles are wide, those on both sides of
/// a gap leave room for other elements between them, and those along a model edge leave the rest of it as it is.
/// Errors: Cancelled.
WantedHeights find_wanted_heights(const CurveStarts& starts, const TaskRunner& runner);

}  // namespace tetloom::layers
