#include "core/io/solver/groups.hpp"

#include <algorithm>
#include <cctype>
#include <map>

#include "core/base/lists.hpp"
#include "core/io/element_nodes_detail.hpp"
#include "core/io/formats_detail.hpp"

namespace tetloom::detail {
namespace {

constexpr std::size_t kLongest = 64;

bool is_word(char c) { return std::isalnum(static_cast<unsigned char>(c)) != 0 && static_cast<unsigned char>(c) < 128; }

const EntityAttributes* attributes_of(const EntityTable& entities, std::size_t dim, std::uint32_t tag) {
  return tag > 0 && tag <= entities[dim].size() ? &entities[dim][tag - 1] : nullptr;
}

std::string group_of(const EntityTable& entities, std::size_t dim, std::uint32_t tag) {
  const EntityAttributes* attributes = attributes_of(entities, dim, tag);
  return attributes ? solver_name(attributes->group) : std::string();
}

std::string name_of(const EntityTable& entities, std::size_t dim, std::uint32_t tag) {
  const EntityAttributes* attributes = attributes_of(entities, dim, tag);
  const std::string given = attributes ? solver_name(attributes->name) : std::string();
  return given.empty() ? std::string(kEntityKinds[dim]) + "_" + std::to_string(tag) : given;
}

using ElementsByTag = std::map<std::uint32_t, std::vector<std::uint32_t>>;

std::array<ElementsByTag, 4> collect(const Mesh& mesh) {
  std::array<ElementsByTag, 4> all;
  for (std::uint32_t v = 0; v < mesh.points.size(); ++v) {
    const ModelEntity entity = entity_of_point(mesh, v);
    if (entity.valid() && entity.dim == 0) all[0][entity.tag()].push_back(v);
  }
  std::array<std::uint32_t, 4> count{};
  for_each_block(mesh, [&](Block block, const auto& elements, const auto& entities) {
    const auto dim = static_cast<std::size_t>(dimension_of(block));
    std::uint32_t last = 0;
    std::vector<std::uint32_t>* list = nullptr;  // elements of one entity mostly follow each other
    for (std::size_t e = 0; e < elements.size(); ++e) {
      const std::uint32_t tag = tag_of_index(entities[e]);
      if (!list || tag != last) list = &all[dim][last = tag];
      list->push_back(count[dim]++);
    }
  });
  return all;
}

TagsByDim tags_of(const std::array<ElementsByTag, 4>& elements) {
  TagsByDim tags;
  for (std::size_t dim = 0; dim < tags.size(); ++dim)
    for (const auto& [tag, list] : elements[dim]) tags[dim].push_back(tag);
  return tags;
}

// Each entity is a group, those of one EntityAttributes::group together.
std::vector<Group> join_entities(const EntityTable& entities, std::size_t dim, const std::vector<std::uint32_t>& tags) {
  std::vector<Group> groups;
  std::map<std::string, std::size_t> place;
  for (const std::uint32_t tag : tags) {
    const std::string name = lower_case(group_of(entities, dim, tag));
    const auto known = name.empty() ? place.end() : place.find(name);
    if (known != place.end()) {
      groups[known->second].tags.push_back(tag);
      continue;
    }
    if (!name.empty()) place.emplace(name, groups.size());
    groups.push_back({{}, {tag}, {}});
  }
  return groups;
}

void put_elements(std::array<ElementsByTag, 4>&& elements, Groups& groups) {
  for (std::size_t dim = 0; dim < groups.size(); ++dim)
    for (Group& group : groups[dim])
      for (const std::uint32_t tag : group.tags) {
        const auto found = elements[dim].find(tag);
        if (found == elements[dim].end()) continue;
        if (group.elements.empty()) {
          group.elements = std::move(found->second);
          continue;
        }
        group.elements.insert(group.elements.end(), found->second.begin(), found->second.end());
        std::ranges::sort(group.elements);
      }
}

}  // namespace

std::string lower_case(std::string text) {
  for (char& c : text) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return text;
}

std::string own_name(const std::string& name, std::set<std::string>& taken) {
  if (taken.insert(lower_case(name)).second) return name;
  for (int number = 2;; ++number) {
    const std::string suffix = "_" + std::to_string(number);
    std::string numbered = name.substr(0, kLongest - suffix.size()) + suffix;
    if (taken.insert(lower_case(numbered)).second) return numbered;
  }
}

std::string solver_name(const std::string& name) {
  std::string result;
  for (const char c : name) {
    const char next = is_word(c) ? c : '_';
    if (next != '_' || (!result.empty() && result.back() != '_')) result += next;
  }
  while (!result.empty() && result.back() == '_') result.pop_back();
  if (!result.empty() && std::isalpha(static_cast<unsigned char>(result[0])) == 0) result.insert(0, "n_");
  return result.substr(0, kLongest);
}

TagsByDim tags_with_elements(const Mesh& mesh) { return tags_of(collect(mesh)); }

Groups name_groups(const EntityTable& entities, const TagsByDim& tags) {
  Groups groups;
  std::set<std::string> taken;
  constexpr std::array<std::size_t, 4> kOrder{3, 2, 1, 0};
  for (const std::size_t dim : kOrder) groups[dim] = join_entities(entities, dim, tags[dim]);
  // Names that were asked for come first: another entity of that name gets a number.
  for (const bool is_asked : {true, false})
    for (const std::size_t dim : kOrder)
      for (Group& group : groups[dim]) {
        const std::string asked = group_of(entities, dim, group.tags[0]);
        if (asked.empty() != is_asked)
          group.name = own_name(is_asked ? asked : name_of(entities, dim, group.tags[0]), taken);
      }
  return groups;
}

Groups make_groups(const Mesh& mesh) {
  std::array<ElementsByTag, 4> elements = collect(mesh);
  Groups groups = name_groups(mesh.entities, tags_of(elements));
  put_elements(std::move(elements), groups);
  return groups;
}

Groups make_groups(const Mesh& mesh, Groups named) {
  put_elements(collect(mesh), named);
  return named;
}

std::vector<NamedGroup> list_names(const Groups& groups, const EntityTable& entities) {
  std::vector<NamedGroup> names;
  for (std::size_t dim = 0; dim < groups.size(); ++dim)
    for (const Group& group : groups[dim])
      for (const std::uint32_t tag : group.tags) {
        if (tag == 0) continue;
        const EntityAttributes* attributes = attributes_of(entities, dim, tag);
        names.push_back(
            {ModelEntity(static_cast<int>(dim), tag - 1), attributes ? attributes->name : std::string(), group.name});
      }
  std::ranges::sort(names, {}, [](const NamedGroup& name) { return std::pair(name.entity.dim, name.entity.index); });
  return names;
}

std::vector<std::uint32_t> points_of(const Mesh& mesh, const ElementNodes& nodes, int dim, const Group& group) {
  if (dim == 0) return group.elements;
  std::vector<std::uint32_t> points;
  std::size_t first = 0;  // of the block, among all elements of the dimension
  for_each_block(mesh, [&](Block block, const auto& elements, const auto&) {
    if (dimension_of(block) != dim) return;
    auto at = std::ranges::lower_bound(group.elements, first);
    for (; at != group.elements.end() && *at < first + elements.size(); ++at) {
      const NodeList own = nodes.of(elements[*at - first], block);
      points.insert(points.end(), own.begin(), own.end());
    }
    first += elements.size();
  });
  sort_unique(points);
  return points;
}

}  // namespace tetloom::detail
