#pragma once
// Boundary layers: what is asked of them, and what became of them.
#include <cstddef>
#include <cstdint>
#include <string_view>
#include <vector>

#include "tetloom/error.hpp"
#include "tetloom/ids.hpp"
#include "tetloom/vec.hpp"

namespace tetloom {

/// Layers on one face of the model, its wall. Layer i, from 0, is first_height · growth^i high, measured normal to the
/// wall.
struct WallLayers {
  ModelFaceId face;
  bool in_front = true, behind = true;  ///< in the regions on these sides of the face, where there are regions
  double first_height = 0;              ///< model length, > 0
  double growth = 1.2;                  ///< of the heights from layer to layer, 1 to 10
  int count = 0;                        ///< of layers, up to 1000; 0: until the last is .8 of the size at its place
  double thickness = 0;                 ///< of all layers together at most, model length; 0: whatever they come to
};

/// Cell fields of meshes with layers, beside kStackField (tetloom/partition.hpp): the layer, 1 at the wall and 0 above
/// the layers, and its height at the place, 0 above the layers.
inline constexpr std::string_view kLayerField = "layer", kHeightField = "height";

/// The layers of all walls.
struct LayerOptions {
  std::vector<WallLayers> walls;  ///< each face once; empty: no layers
  bool all_tets = false;          ///< all cells are split into tets
  /// Degrees, 45 to 180; 0: none. At convex edges where the normals of both sides turn by more than this, each side has
  /// layers of its own, and wedges of cells lie between them: fans.
  double fan_angle = 50;
};

/// Why there are fewer layers at a place than were asked for.
enum class LayerLimit : std::uint8_t {
  None,
  Gap,        ///< another wall, or the top of its layers, is near
  Concave,    ///< layers from different sides would run into each other
  Isotropy,   ///< the next layer would be higher than its triangle is wide
  NoNormal,   ///< no direction leads away from all faces at the place
  Cell,       ///< a cell, or the front above it, would have been too poor
  Crossing,   ///< the top of the layers would have crossed a surface
  SideAngle,  ///< a face beside the wall meets it at less than 30 or more than 150 degrees, or has no room for layers
  Filling,    ///< the space above the layers could not be filled
  Fan         ///< a sharp convex edge has no room, or no shape, for a fan; there may be all layers nevertheless
};
constexpr std::size_t kLayerLimits = 10;

/// "gap", "concave", "isotropy", "no_normal", "cell", "crossing", "side_angle", "filling", "fan"; "none".
std::string_view to_string(LayerLimit limit);

/// Places of one face where there are fewer layers than asked for, for one reason.
struct LimitedLayers {
  LayerLimit reason = LayerLimit::None;
  ModelFaceId face;
  double area = 0;       ///< of the triangles concerned; model length²
  double uncovered = 0;  ///< of those without any layer of prisms
  Vec3 point;            ///< where fewest of the layers are left
};

/// What became of the layers on some area of walls. Shares are of that area, from 0 to 1.
struct LayerCoverage {
  double area = 0;                       ///< model length²; both sides of a wall count
  double full_count = 0;                 ///< has all its layers
  double at_least_one = 0;               ///< has a layer of prisms
  double thickness = 0;                  ///< mean share of the asked thickness that is reached
  double first_height_within_10pct = 0;  ///< of the area with a layer: where the first one is as high as asked
  double first_height_error = 0;         ///< mean over the area with a layer, relative to what was asked
  double growth_error = 0;               ///< the largest, relative, from layer to layer along straight growth curves
};

/// The same for one face.
struct FaceLayers {
  ModelFaceId face;
  LayerCoverage coverage;
};

/// Cells in layers and how well they cover the walls.
struct LayerFigures {
  std::size_t prisms = 0, pyramids = 0, hexes = 0, tets = 0;  ///< cells in layers
  LayerCoverage coverage;
  std::size_t fans = 0;            ///< vertices of sharp convex edges with several growth curves
  double min_scaled_jacobian = 1;  ///< over the corners of all but tets, and that of tets where their edge from layer
                                   ///< to layer starts; 1 for the prism that stands on an equilateral triangle
  double scaled_jacobian_p1 = 1;   ///< the first percentile of the cells' least one
  double first_angle_p99 = 0;      ///< degrees between the edges of first cells and the wall's normal, but at ridges;
                                   ///< 99 % of the area have less
  double seconds = 0;
  std::vector<FaceLayers> by_face;     ///< ascending
  std::vector<LimitedLayers> limited;  ///< largest area first
};

}  // namespace tetloom
