#pragma once
// Private to core/io: one reader and one writer per format, and what they share.
#include <algorithm>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/io/atomic_file.hpp"
#include "core/io/input_detail.hpp"
#include "core/mesh/mesh.hpp"

namespace tetloom::detail {

// Pre of all writers: require_consistent(mesh).
void write_vtu(const Mesh& mesh, AtomicFile& file);
void write_msh(const Mesh& mesh, AtomicFile& file);
void write_medit_text(const Mesh& mesh, AtomicFile& file);
void write_medit_binary(const Mesh& mesh, AtomicFile& file);
void write_stl(const Mesh& mesh, AtomicFile& file);

/// A comment in MSH files of our own, whose volumes have correctly oriented boundaries; those of others often have not.
inline constexpr std::string_view kMshSignature = "tetloom: signed boundaries of volumes point outwards";

// The readers leave checking indices and array lengths to finish_mesh.
Mesh read_vtu(const InputFile& file);
Mesh read_msh(const InputFile& file);
Mesh read_medit_text(const InputFile& file);
Mesh read_medit_binary(const InputFile& file);
Mesh read_stl(const InputFile& file);

/// The index that a tag in a file stands for: none for 0 and for what no index can hold.
inline std::uint32_t index_of_tag(std::int64_t tag) {
  return tag >= 1 && tag <= 0xffffffff ? static_cast<std::uint32_t>(tag - 1) : 0xffffffffu;
}
/// The inverse: 0 for none.
inline std::uint32_t tag_of_index(std::uint32_t index) { return index + 1; }

/// A point index in a file as it is stored in a Mesh: what does not fit becomes an index that is out of any range.
inline std::uint32_t stored_index(std::uint64_t index) {
  return index < 0xffffffffu ? static_cast<std::uint32_t>(index) : 0xffffffffu;
}

/// Model vertices that a file names.
struct Corner {
  std::uint32_t point = 0;
  std::uint32_t index = 0;  ///< of the model vertex
};

/// Gives every point the entity of the lowest-dimensional elements that use it, where those agree, and model vertices
/// to `corners`. Replaces all of `point_to_entity`. Pre: indices in range.
void classify_points(Mesh& mesh, std::span<const Corner> corners);

/// Throws Error(InputUnreadable) where an index is out of range, Error(InputUnsuitable) where there are no elements.
void check_read_mesh(const InputFile& file, const Mesh& mesh);

/// Throws Error(InputUnsuitable) for elements that a Mesh cannot hold.
[[noreturn]] void refuse_elements(const InputFile& file, const std::string& kind);

/// Puts `elements` in the order of `ids` where those are a permutation of consecutive numbers; else leaves the order
/// of the file.
template <class Element>
void restore_order(std::vector<Element>& elements, std::vector<std::uint32_t>& entities,
                   const std::vector<std::uint64_t>& ids) {
  if (std::is_sorted(ids.begin(), ids.end()) || ids.empty()) return;
  const auto [low, high] = std::minmax_element(ids.begin(), ids.end());
  const std::uint64_t first = *low;
  if (*high - first != ids.size() - 1) return;
  std::vector<bool> seen(ids.size(), false);
  for (const std::uint64_t id : ids) {
    if (seen[id - first]) return;
    seen[id - first] = true;
  }
  std::vector<Element> ordered(elements.size());
  std::vector<std::uint32_t> ordered_entities(entities.size());
  for (std::size_t i = 0; i < ids.size(); ++i) {
    ordered[ids[i] - first] = elements[i];
    ordered_entities[ids[i] - first] = entities[i];
  }
  elements.swap(ordered);
  entities.swap(ordered_entities);
}

}  // namespace tetloom::detail
