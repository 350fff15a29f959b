#pragma once
// --layers: the walls of a model and the boundary layers on them.
//
//   --layers 'wall*,3,7-9' --first-height 1e-4 --growth 1.2 --layer-count 20
//   --layers '*,!cap*'                       every face that bounds a region, but those
//   --layers walls.json
//   {"all_tets": false, "fan_angle": 50,
//    "walls": [{"faces": ["wing*", 3], "first_height": 1e-4, "growth": 1.2, "count": 20, "side": "front"},
//              {"faces": ["hull"], "y_plus": 1, "velocity": 40, "density": 1.2, "viscosity": 1.8e-5, "length": 2}]}
//
// Items are those of --group. Of several entries that name a face, the last one holds.
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "apps/tetloom/entity_groups.hpp"
#include "tetloom/layers.hpp"
#include "tetloom/model.hpp"

namespace tetloom::app {

/// Where the first cell shall end, in wall units, and the flow that says how much that is; SI units.
struct WallUnits {
  double y_plus = 0, velocity = 0, density = 0, viscosity = 0, length = 0;
};

/// The height in metres, with the friction of a turbulent boundary layer on a flat plate: a coefficient of
/// .026 / Re^(1/7) (White 2011).
double height_of(const WallUnits& units);

/// One entry: faces, and what is asked of them.
struct WallWish {
  std::vector<GroupItem> faces, but;
  WallLayers layers;  ///< without a face
  std::optional<WallUnits> units;
};

/// Layers as the command was asked for them.
struct LayersWish {
  std::vector<WallWish> walls;  ///< empty: none
  bool all_tets = false;
  std::optional<double> fan_angle;  ///< degrees
  bool has_far_field = false;       ///< the faces of the box around the model are no walls: "*" leaves them out
};

/// The value of --layers: the name of a file that ends in .json, which is read, or items with commas between them.
/// `common` holds for what the file does not say. Errors: InvalidArgument.
LayersWish parse_layers(const std::string& text, const WallLayers& common);

/// The layers that the wishes mean. Errors: InvalidArgument that lists all items that mean nothing in `model`; for
/// faces that bound no region; for wall units where the model does not say its unit of length.
LayerOptions find_wall_layers(const LayersWish& wish, const GeometricModel& model);

}  // namespace tetloom::app
