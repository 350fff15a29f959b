#pragma once
// The ways on which points of layers leave the walls.
#include <cstdint>
#include <span>
#include <vector>

#include "mesher/layers/side_faces.hpp"
#include "mesher/layers/walls.hpp"
#include "tetloom/tasks.hpp"

namespace tetloom::layers {

/// A polyline for every growth curve, and why it ends.
struct GrowthPaths {
  std::vector<std::vector<Vec3>> fronts;     ///< the points of all curves after step 0, 1, …; first the feet
  std::vector<std::vector<double>> heights;  ///< above the wall, as layers count them, of those points
  std::vector<double> reached;               ///< height of each curve
  std::vector<double> stretch;               ///< at the wall: length along a curve over height, 1 to 2
  std::vector<LayerLimit> limits;            ///< why a curve is shorter than asked for
  /// Vertices of fans whose layers would be too thin for lack of room. There are no fronts then.
  std::vector<std::uint32_t> fans_without_room;

  /// The point of the curve at this height; at most `reached`.
  Vec3 point_at(std::uint32_t curve, double height) const;
};

/// Paths as long as the layers asked for, or shorter: where another wall is near, where no direction sees all triangles
/// around a vertex, and where the prisms between two fronts would not be sound. All curves go on at once, by a third of
/// the width of their triangles a step; directions follow the front, smoothed within what its triangles see. The result
/// depends on the arguments alone. Errors: Cancelled.
GrowthPaths make_paths(const Mesh& mesh, std::span<const FaceSides> face_to_sides, const Walls& walls,
                       const SideFaces& sides, const TaskRunner& runner);

}  // namespace tetloom::layers
