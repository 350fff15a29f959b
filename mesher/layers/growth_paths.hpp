#pragma once
// The ways on which points of layers leave the walls.
#include <cstdint>
#include <span>
#include <vector>

#include "mesher/layers/side_faces.hpp"
#include "mesher/layers/walls.hpp"
#include "mesher/layers/wanted_heights.hpp"
#include "tetloom/tasks.hpp"

namespace tetloom::layers {

/// A polyline for every growth curve, and why it ends.
struct GrowthPaths {
  std::vector<std::vector<Vec3>> fronts;     ///< the points of all curves after step 0, 1, …; first the feet
  std::vector<std::vector<double>> heights;  ///< above the wall, as layers count them, of those points
  std::vector<double> reached;               ///< height of each curve
  std::vector<double> stretch;               ///< at the wall: length along a curve over height, 1 to 2
  std::vector<LayerLimit> limits;            ///< why a curve is shorter than asked for
  WantedHeights wanted;                      ///< as high as there is room for
  std::vector<double> pace;                  ///< widths that steps are taken from
  /// Vertices of fans whose layers would be too thin for lack of room. There are no fronts but the feet then.
  std::vector<std::uint32_t> fans_without_room;

  /// The point of the curve at this height; at most `reached`.
  Vec3 point_at(std::uint32_t curve, double height) const;
};

/// Paths that were made before some fans were taken back.
struct KeptPaths {
  const GrowthPaths* paths = nullptr;     ///< none: there are no such paths
  std::span<const std::uint32_t> curves;  ///< per curve, its number there, or none where it is grown anew
};

/// What paths start from.
struct GrowthStart {
  const Mesh& mesh;
  std::span<const FaceSides> face_to_sides;
  const Walls& walls;
  const SideFaces& sides;
};

/// Paths as long as the layers asked for, or shorter: where another wall is near, where no direction sees all triangles
/// around a vertex, and where the prisms between two fronts would not be sound. All curves go on at once, by a third of
/// the width of their triangles a step; directions follow the front, smoothed within what its triangles see. Curves
/// that are kept go where they went before, step by step. The result depends on the arguments alone. Errors: Cancelled.
GrowthPaths make_paths(const GrowthStart& start, const TaskRunner& runner, const KeptPaths& kept = {});

}  // namespace tetloom::layers
