#pragma once
// Model entities for the groups of a file that knows names alone.
#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "tetloom/mesh_data.hpp"

namespace tetloom::detail {

/// Gives every group of one dimension an entity: those that files of our own call "face_12" get their tag back, all
/// others the lowest tags that are left, in the order of the file, and their name.
class GroupTags {
 public:
  explicit GroupTags(int dim) : dim_(dim) {}
  /// The number of a group by its name, counted from 0 in the order in which they are first asked for.
  std::uint32_t find(std::string_view name);
  /// The index of the entity of each group, once all are known; notes the names of the others in `entities`.
  std::vector<std::uint32_t> assign(EntityTable& entities) const;

 private:
  int dim_;
  std::map<std::string, std::uint32_t, std::less<>> numbers_;
  std::vector<std::string> names_;
};

}  // namespace tetloom::detail
