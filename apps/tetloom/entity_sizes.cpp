#include "apps/tetloom/entity_sizes.hpp"

#include <algorithm>
#include <array>
#include <nlohmann/json.hpp>
#include <numeric>
#include <string_view>

#include "apps/tetloom/json_entry.hpp"
#include "apps/tetloom/quantities.hpp"

namespace tetloom::app {
namespace {

EntitySizeWish parse_entity(const nlohmann::json& json, const std::string& place) {
  const JsonEntry entry(json, place, {"dim", "tag", "name", "size"});
  EntitySizeWish wish;
  if (const auto dim = entry.integer("dim", 0, 3)) wish.dim = static_cast<int>(*dim);
  if (const auto tag = entry.integer("tag", 1, 0xfffffffe)) wish.tag = static_cast<std::uint32_t>(*tag);
  wish.name = entry.text("name");
  wish.size = entry.size();
  if (wish.tag.has_value() == !wish.name.empty()) refuse_json(place + " must have either a 'tag' or a 'name'");
  if (wish.tag && !wish.dim)
    refuse_json(place + " has a 'tag' and so needs a 'dim': 0 vertex, 1 edge, 2 face, 3 region");
  return wish;
}

PointSize parse_point(const nlohmann::json& json, const std::string& place) {
  const JsonEntry entry(json, place, {"point", "size"});
  return {entry.point("point"), entry.size()};
}

/// How many letters one has to change, add or leave out to get from `a` to `b` (Levenshtein).
std::size_t edit_distance(std::string_view a, std::string_view b) {
  std::vector<std::size_t> row(b.size() + 1);
  std::iota(row.begin(), row.end(), std::size_t{0});
  for (std::size_t i = 0; i < a.size(); ++i) {
    std::size_t diagonal = row[0];
    row[0] = i + 1;
    for (std::size_t j = 0; j < b.size(); ++j) {
      const std::size_t replaced = diagonal + (a[i] == b[j] ? 0 : 1);
      diagonal = row[j + 1];
      row[j + 1] = std::min({replaced, row[j] + 1, row[j + 1] + 1});
    }
  }
  return row.back();
}

std::string closest_name(const GeometricModel& model, const std::string& name) {
  std::string best;
  std::size_t best_distance = std::max<std::size_t>(1, name.size() / 3) + 1;
  for (int dim = 3; dim >= 0; --dim) {
    for (std::size_t i = 0; i < model.topology().count(dim); ++i) {
      const std::string& other = model.attributes(ModelEntity(dim, static_cast<std::uint32_t>(i))).name;
      if (other.empty() || other.size() > name.size() + best_distance) continue;
      const std::size_t distance = edit_distance(name, other);
      if (distance < best_distance) best = other, best_distance = distance;
    }
  }
  return best;
}

/// Adds the entities that the wish means; false where the model has none.
bool find_entities(const EntitySizeWish& wish, const GeometricModel& model, SizeOptions& options) {
  if (wish.tag) {
    if (*wish.tag > model.topology().count(*wish.dim)) return false;
    options.entity_sizes.push_back({ModelEntity(*wish.dim, *wish.tag - 1), wish.size});
    return true;
  }
  bool found = false;
  for (int dim = 0; dim <= 3; ++dim) {
    if (wish.dim && *wish.dim != dim) continue;
    for (std::size_t i = 0; i < model.topology().count(dim); ++i) {
      const ModelEntity entity(dim, static_cast<std::uint32_t>(i));
      if (model.attributes(entity).name != wish.name) continue;
      options.entity_sizes.push_back({entity, wish.size});
      found = true;
    }
  }
  return found;
}

std::string describe_missing(const EntitySizeWish& wish, const GeometricModel& model) {
  const std::string kind(wish.dim ? kEntityKinds[static_cast<std::size_t>(*wish.dim)] : "entity");
  if (wish.tag) {
    return kind + " " + std::to_string(*wish.tag) + " (the model has " +
           std::to_string(model.topology().count(*wish.dim)) + ")";
  }
  const std::string closest = closest_name(model, wish.name);
  return kind + " named '" + wish.name + "'" +
         (closest.empty() || closest == wish.name ? "" : " (did you mean '" + closest + "'?)");
}

}  // namespace

SizesFile parse_sizes(const std::string& text, const std::string& path) {
  const nlohmann::json root = parse_json(text, path);
  const JsonEntry whole(root, "'" + path + "'", {"entities", "points"});
  SizesFile sizes;
  for_each_item(root, path, "entities", [&](const nlohmann::json& json, const std::string& place) {
    sizes.entities.push_back(parse_entity(json, place));
  });
  for_each_item(root, path, "points", [&](const nlohmann::json& json, const std::string& place) {
    sizes.points.push_back(parse_point(json, place));
  });
  return sizes;
}

SizesFile read_sizes(const std::filesystem::path& path) {
  return parse_sizes(read_text(path, "--sizes"), path.string());
}

void apply_sizes(const SizesFile& file, const GeometricModel& model, SizeOptions& options) {
  std::vector<std::string> missing;
  for (const EntitySizeWish& wish : file.entities) {
    if (!find_entities(wish, model, options)) missing.push_back(describe_missing(wish, model));
  }
  if (!missing.empty()) {
    std::string message = "the file of --sizes asks for what the model does not have: " + missing[0];
    for (std::size_t i = 1; i < missing.size(); ++i) message += ", " + missing[i];
    refuse_json(message);
  }
  options.point_sizes.insert(options.point_sizes.end(), file.points.begin(), file.points.end());
}

}  // namespace tetloom::app
