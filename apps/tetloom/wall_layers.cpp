#include "apps/tetloom/wall_layers.hpp"

#include <algorithm>
#include <cmath>
#include <map>

#include "apps/tetloom/json_entry.hpp"
#include "apps/tetloom/option_values.hpp"

namespace tetloom::app {
namespace {

constexpr int kMostLayers = 1000;

// "!NAME" takes faces away.
void add_item(const std::string& text, const std::string& place, WallWish& wish) {
  const bool is_taken_away = text.starts_with('!');
  (is_taken_away ? wish.but : wish.faces).push_back(parse_group_item(is_taken_away ? text.substr(1) : text, 2, place));
}

void add_item(const nlohmann::json& json, const std::string& place, WallWish& wish) {
  if (json.is_string()) return add_item(json.get<std::string>(), place, wish);
  wish.faces.push_back(parse_group_item(json, 2, place));
}

WallUnits parse_units(const JsonEntry& entry) {
  WallUnits units{entry.number("y_plus"), entry.number("velocity"), entry.number("density"), entry.number("viscosity"),
                  entry.number("length")};
  for (const double value : {units.y_plus, units.velocity, units.density, units.viscosity, units.length})
    if (!(value > 0)) refuse_json(entry.place() + ": y_plus, velocity, density, viscosity and length must be positive");
  return units;
}

WallWish parse_wall(const nlohmann::json& json, const std::string& place, const WallLayers& common) {
  const JsonEntry entry(json, place,
                        {"faces", "side", "first_height", "growth", "count", "thickness", "y_plus", "velocity",
                         "density", "viscosity", "length"});
  WallWish wish;
  wish.layers = common;
  if (!json.contains("faces") || !json["faces"].is_array() || json["faces"].empty())
    refuse_json(place + ": 'faces' must be a list that is not empty");
  for (const nlohmann::json& item : json["faces"]) add_item(item, place, wish);
  if (const std::string side = entry.text("side"); side == "front" || side == "back") {
    wish.layers.in_front = side == "front";
    wish.layers.behind = side == "back";
  } else if (!side.empty() && side != "both") {
    refuse_json(place + ": 'side' must be front, back or both");
  }
  if (json.contains("first_height")) wish.layers.first_height = entry.number("first_height");
  if (json.contains("growth")) wish.layers.growth = entry.number("growth");
  if (json.contains("thickness")) wish.layers.thickness = entry.number("thickness");
  wish.layers.count = static_cast<int>(entry.integer("count", 0, kMostLayers).value_or(wish.layers.count));
  if (json.contains("y_plus")) wish.units = parse_units(entry);
  if (json.contains("y_plus") && json.contains("first_height"))
    refuse_json(place + " has both 'y_plus' and 'first_height'");
  return wish;
}

LayersWish parse_file(const std::string& path, const WallLayers& common) {
  const nlohmann::json root = parse_json(read_text(path, "--layers"), path);
  const JsonEntry whole(root, "'" + path + "'", {"walls", "all_tets", "fan_angle"});
  LayersWish wish;
  for_each_item(root, path, "walls", [&](const nlohmann::json& json, const std::string& place) {
    wish.walls.push_back(parse_wall(json, place, common));
  });
  if (wish.walls.empty()) refuse_json("'" + path + "' has no walls");
  if (root.contains("all_tets")) {
    if (!root["all_tets"].is_boolean()) refuse_json("'" + path + "': 'all_tets' must be true or false");
    wish.all_tets = root["all_tets"].get<bool>();
  }
  if (root.contains("fan_angle")) wish.fan_angle = whole.number("fan_angle");
  return wish;
}

bool bounds_region(const GeometricModel& model, std::uint32_t face) {
  const FaceSides& sides = model.topology().face_to_sides[face];
  return sides.front.valid() || sides.back.valid();
}

constexpr std::uint32_t kFacesOfBox = 6;  // the last ones

// "*" is every face of the boundary, with a name or without; of a model without regions every face, which is refused
// with its place.
bool means_face(const GroupItem& item, std::uint32_t face, const GeometricModel& model, bool has_far_field) {
  const std::size_t end = model.topology().face_count() - (has_far_field ? kFacesOfBox : 0);
  if (item.pattern == "*") return face < end && (bounds_region(model, face) || model.topology().region_count() == 0);
  return is_meant(item, ModelFaceId(face), model);
}

// The faces that an item means; notes it in `missing` where there are none.
std::vector<std::uint32_t> faces_of(const GroupItem& item, const GeometricModel& model, bool has_far_field,
                                    std::string& missing) {
  std::vector<std::uint32_t> faces;
  for (std::uint32_t f = 0; f < model.topology().face_count(); ++f)
    if (means_face(item, f, model, has_far_field)) faces.push_back(f);
  if (faces.empty()) missing += (missing.empty() ? "'" : ", '") + item.text + "'";
  return faces;
}

WallLayers with_height(const WallWish& wish, const GeometricModel& model) {
  WallLayers layers = wish.layers;
  if (!wish.units) return layers;
  if (model.metres_per_unit() == 0) refuse_json("--layers: y_plus needs a model that says the unit of its lengths");
  layers.first_height = height_of(*wish.units) / model.metres_per_unit();
  return layers;
}

}  // namespace

double height_of(const WallUnits& units) {
  const double reynolds = units.density * units.velocity * units.length / units.viscosity;
  const double friction = 0.026 / std::pow(reynolds, 1.0 / 7);
  const double friction_velocity = units.velocity * std::sqrt(friction / 2);
  return units.y_plus * units.viscosity / (units.density * friction_velocity);
}

LayersWish parse_layers(const std::string& text, const WallLayers& common) {
  if (text.ends_with(".json")) return parse_file(text, common);
  const std::string place = "--layers '" + text + "'";
  WallWish wish;
  wish.layers = common;
  for (const std::string& item : items_of(text)) add_item(item, place, wish);
  if (wish.faces.empty()) refuse_json(place + " names no face");
  LayersWish layers;
  layers.walls.push_back(std::move(wish));
  return layers;
}

LayerOptions find_wall_layers(const LayersWish& wish, const GeometricModel& model) {
  std::map<std::uint32_t, WallLayers> walls;
  std::string missing;
  for (const WallWish& one : wish.walls) {
    std::map<std::uint32_t, WallLayers> meant;
    const WallLayers layers = with_height(one, model);
    for (const GroupItem& item : one.faces)
      for (const std::uint32_t f : faces_of(item, model, wish.has_far_field, missing)) meant[f] = layers;
    for (const GroupItem& item : one.but)
      for (const std::uint32_t f : faces_of(item, model, wish.has_far_field, missing)) meant.erase(f);
    for (auto& [face, wall] : meant) {
      wall.face = ModelFaceId(face);
      walls[face] = wall;
    }
  }
  if (!missing.empty()) refuse_json("--layers: the model has no face that these mean: " + missing);
  LayerOptions options;
  options.all_tets = wish.all_tets;
  options.fan_angle = wish.fan_angle.value_or(options.fan_angle);
  for (const auto& [face, wall] : walls) options.walls.push_back(wall);
  if (options.walls.empty() && !wish.walls.empty()) refuse_json("--layers: no face is left to have layers");
  return options;
}

}  // namespace tetloom::app
