#include "core/io/solver/group_tags.hpp"

#include <array>
#include <charconv>
#include <optional>
#include <set>

namespace tetloom::detail {
namespace {

constexpr std::array<std::string_view, 4> kPrefixes{"vertex_", "edge_", "face_", "region_"};
constexpr std::uint32_t kLargestTag = 1'000'000;  // of a name; tables are as long

std::optional<std::uint32_t> tag_in(std::string_view name, int dim) {
  const std::string_view prefix = kPrefixes[static_cast<std::size_t>(dim)];
  if (!name.starts_with(prefix)) return {};
  const std::string_view digits = name.substr(prefix.size());
  std::uint32_t tag = 0;
  const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), tag);
  const bool is_tag = error == std::errc() && end == digits.data() + digits.size() && digits.front() != '0';
  return is_tag && tag <= kLargestTag ? std::optional(tag) : std::nullopt;
}

}  // namespace

std::uint32_t GroupTags::find(std::string_view name) {
  const auto known = numbers_.find(name);
  if (known != numbers_.end()) return known->second;
  names_.emplace_back(name);
  return numbers_.emplace(std::string(name), static_cast<std::uint32_t>(names_.size() - 1)).first->second;
}

std::vector<std::uint32_t> GroupTags::assign(EntityTable& entities) const {
  std::set<std::uint32_t> taken;
  for (const std::string& name : names_)
    if (const auto tag = tag_in(name, dim_)) taken.insert(*tag);
  std::vector<std::uint32_t> indices;
  std::vector<EntityAttributes>& table = entities[static_cast<std::size_t>(dim_)];
  std::uint32_t next = 1;
  for (const std::string& name : names_) {
    const std::optional<std::uint32_t> own = tag_in(name, dim_);
    while (!own && taken.contains(next)) ++next;
    const std::uint32_t tag = own ? *own : next++;
    indices.push_back(tag - 1);
    if (table.size() < tag) table.resize(tag);
    if (!own) table[tag - 1].name = name;
  }
  return indices;
}

}  // namespace tetloom::detail
