#include "apps/tetloom/entity_groups.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numbers>

#include "apps/tetloom/json_entry.hpp"
#include "apps/tetloom/option_values.hpp"
#include "apps/tetloom/text_table.hpp"

namespace tetloom::app {
namespace {

constexpr std::array<const char*, 4> kKinds{"vertices", "edges", "faces", "regions"};

std::optional<int> dim_of_kind(const std::string& kind) {
  const auto* found = std::ranges::find(kKinds, kind);
  return found == kKinds.end() ? std::nullopt : std::optional(static_cast<int>(found - kKinds.begin()));
}

std::optional<Vec3> axis_of(const std::string& text) {
  if (text.size() != 2 || (text[0] != '+' && text[0] != '-') || text[1] < 'x' || text[1] > 'z') return {};
  Vec3 direction;
  direction[text[1] - 'x'] = text[0] == '+' ? 1 : -1;
  return direction;
}

bool is_color(const std::string& text) {
  constexpr std::size_t kLength = 7;
  return text.size() == kLength && text[0] == '#' &&
         text.find_first_not_of("0123456789abcdefABCDEF", 1) == std::string::npos;
}

GroupItem parse_normal(const nlohmann::json& json, int dim, const std::string& place) {
  const JsonEntry entry(json, place, {"normal", "angle"});
  if (dim != 2) refuse_json(place + ": only faces have normals");
  GroupItem item;
  item.normal.direction = normalized(entry.point("normal"));
  if (item.normal.direction == Vec3{}) refuse_json(place + ": 'normal' has no direction");
  if (json.contains("angle")) item.normal.angle = entry.number("angle");
  if (!(item.normal.angle > 0 && item.normal.angle <= 180))
    refuse_json(place + ": 'angle' must lie between 0 and 180 degrees");
  item.text = json.dump();
  return item;
}

GroupWish parse_wish(const nlohmann::json& json, const std::string& place) {
  const JsonEntry entry(json, place, {"name", kKinds[0], kKinds[1], kKinds[2], kKinds[3]});
  GroupWish wish;
  wish.name = entry.text("name");
  if (wish.name.empty()) refuse_json(place + " has no 'name'");
  int kinds = 0;
  for (std::size_t dim = 0; dim < kKinds.size(); ++dim) {
    if (!json.contains(kKinds[dim])) continue;
    ++kinds;
    wish.dim = static_cast<int>(dim);
    if (!json[kKinds[dim]].is_array()) refuse_json(place + ": '" + kKinds[dim] + "' must be a list");
    for (const nlohmann::json& item : json[kKinds[dim]]) wish.items.push_back(parse_group_item(item, wish.dim, place));
  }
  if (kinds != 1) refuse_json(place + " must have one of 'regions', 'faces', 'edges' and 'vertices'");
  if (wish.items.empty()) refuse_json(place + " has no items");
  return wish;
}

// Whether a name is what a pattern with * and ? means.
bool matches(std::string_view pattern, std::string_view name) {
  std::size_t p = 0, n = 0, star = std::string_view::npos, resumed = 0;
  while (n < name.size()) {
    if (p < pattern.size() && pattern[p] == '*') {
      star = p++, resumed = n;
    } else if (p < pattern.size() && (pattern[p] == '?' || pattern[p] == name[n])) {
      ++p, ++n;
    } else if (star != std::string_view::npos) {
      p = star + 1, n = ++resumed;
    } else {
      return false;
    }
  }
  while (p < pattern.size() && pattern[p] == '*') ++p;
  return p == pattern.size();
}

// The normals of a face at the middles of some facets, out of its region where there is one at one side.
std::vector<Vec3> normals_of(const GeometricModel& model, ModelFaceId id) {
  constexpr double kTurn = 0.2;  // radians between facets
  const auto face = model.face_geometry(id);
  const Tessellation facets = face->tessellate(norm(model.bounding_box().hi - model.bounding_box().lo), kTurn);
  const FaceSides& sides = model.topology().face_to_sides[id.value];
  const double sign = sides.front.valid() && !sides.back.valid() ? -1 : 1;
  std::vector<Vec3> normals;
  for (const auto& [a, b, c] : facets.tri_to_vert)
    normals.push_back(sign *
                      normalized(cross(facets.points[b] - facets.points[a], facets.points[c] - facets.points[a])));
  return normals;
}

bool points_along(const GeometricModel& model, ModelFaceId face, const NormalWish& wish) {
  const double least = std::cos(wish.angle * std::numbers::pi / 180);
  const std::vector<Vec3> normals = normals_of(model, face);
  return !normals.empty() && std::ranges::all_of(normals, [&](const Vec3& normal) {
    return normal == Vec3{} || dot(normal, wish.direction) >= least;
  });
}

}  // namespace

GroupItem parse_group_item(const std::string& text, int dim, const std::string& place) {
  if (text.empty()) refuse_json(place + ": an item is empty");
  GroupItem item;
  item.text = text;
  const std::size_t dash = text.find('-', 1);
  const auto single = tag_of(text);
  const auto low = dash == std::string::npos ? single : tag_of(text.substr(0, dash));
  const auto high = dash == std::string::npos ? single : tag_of(text.substr(dash + 1));
  if (low && high) {
    if (*low > *high) refuse_json(place + ": the range '" + text + "' runs backwards");
    item.first_tag = *low, item.last_tag = *high;
  } else if (const auto axis = axis_of(text)) {
    if (dim != 2) refuse_json(place + ": only faces have the direction '" + text + "'");
    item.normal.direction = *axis;
  } else if (is_color(text)) {
    item.color = text;
    for (char& c : item.color) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  } else {
    item.pattern = text;
  }
  return item;
}

GroupItem parse_group_item(const nlohmann::json& json, int dim, const std::string& place) {
  if (json.is_string()) return parse_group_item(json.get<std::string>(), dim, place);
  if (json.is_number_unsigned()) return parse_group_item(std::to_string(json.get<std::uint64_t>()), dim, place);
  return parse_normal(json, dim, place);
}

bool is_meant(const GroupItem& item, ModelEntity entity, const GeometricModel& model) {
  if (item.first_tag > 0) return entity.tag() >= item.first_tag && entity.tag() <= item.last_tag;
  const EntityAttributes& attributes = model.attributes(entity);
  if (!item.color.empty()) return attributes.color && format_color(attributes.color) == item.color;
  if (!item.pattern.empty()) return !attributes.name.empty() && matches(item.pattern, attributes.name);
  return points_along(model, ModelFaceId(entity.index), item.normal);
}

GroupWish parse_group(const std::string& text) {
  const std::string place = "--group '" + text + "'";
  const std::size_t equals = text.find('='), colon = text.find(':', equals == std::string::npos ? 0 : equals);
  if (equals == std::string::npos || equals == 0 || colon == std::string::npos)
    refuse_json(place + " must look like NAME=faces:3,7-9,bolt*");
  const std::string kind = text.substr(equals + 1, colon - equals - 1);
  const std::optional<int> dim = dim_of_kind(kind);
  if (!dim) refuse_json(place + ": '" + kind + "' must be regions, faces, edges or vertices");
  GroupWish wish{text.substr(0, equals), *dim, {}};
  for (const std::string& item : items_of(text.substr(colon + 1)))
    wish.items.push_back(parse_group_item(item, *dim, place));
  return wish;
}

std::vector<GroupWish> parse_groups(const std::string& text, const std::string& path) {
  const nlohmann::json root = parse_json(text, path);
  const JsonEntry whole(root, "'" + path + "'", {"groups"});
  std::vector<GroupWish> wishes;
  for_each_item(root, path, "groups", [&](const nlohmann::json& json, const std::string& place) {
    wishes.push_back(parse_wish(json, place));
  });
  return wishes;
}

std::vector<GroupWish> read_groups(const std::filesystem::path& path) {
  return parse_groups(read_text(path, "--groups"), path.string());
}

std::vector<GroupMember> find_members(const std::vector<GroupWish>& wishes, const GeometricModel& model) {
  std::map<std::pair<int, std::uint32_t>, std::string> groups;
  std::string missing;
  for (const GroupWish& wish : wishes)
    for (const GroupItem& item : wish.items) {
      bool is_found = false;
      for (std::uint32_t i = 0; i < model.topology().count(wish.dim); ++i) {
        const ModelEntity entity(wish.dim, i);
        if (!is_meant(item, entity, model)) continue;
        is_found = true;
        const auto [known, is_new] = groups.try_emplace({wish.dim, i}, wish.name);
        if (!is_new && known->second != wish.name)
          refuse_json("the groups '" + known->second + "' and '" + wish.name + "' both want " +
                      kKinds[static_cast<std::size_t>(wish.dim)] + " " + std::to_string(entity.tag()));
      }
      if (!is_found)
        missing += (missing.empty() ? "" : ", ") + std::string(kKinds[static_cast<std::size_t>(wish.dim)]) + " '" +
                   item.text + "' of group '" + wish.name + "'";
    }
  if (!missing.empty()) refuse_json("the model has nothing that these mean: " + missing);
  std::vector<GroupMember> members;
  for (const auto& [key, group] : groups) members.push_back({ModelEntity(key.first, key.second), group});
  return members;
}

void apply_groups(const std::vector<GroupMember>& members, const GeometricModel& model, EntityTable& entities) {
  for (const auto& [entity, group] : members) {
    std::vector<EntityAttributes>& table = entities[entity.dim];
    if (table.size() < model.topology().count(entity.dim)) table.resize(model.topology().count(entity.dim));
    table[entity.index].group = group;
  }
}

void apply_groups(const std::vector<GroupMember>& members, std::vector<PartEntity>& entities) {
  for (PartEntity& known : entities) {
    const auto found = std::ranges::lower_bound(members, known.entity, {}, &GroupMember::entity);
    if (found == members.end() || found->entity != known.entity) continue;
    known.attributes.group = found->group;
    known.has_attributes = true;
  }
}

}  // namespace tetloom::app
