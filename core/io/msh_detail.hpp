#pragma once
// Private to core/io: the numbers of MSH files, their node tags, and the views in them.
#include <algorithm>
#include <array>
#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "core/io/element_nodes_detail.hpp"
#include "core/io/formats_detail.hpp"

namespace tetloom::detail {

/// The edges of elements in the order in which MSH files list the mid nodes on them.
inline constexpr std::array<LocalEdge, 6> kMshTetEdges{{{0, 1}, {1, 2}, {2, 0}, {0, 3}, {2, 3}, {1, 3}}};
inline constexpr std::array<LocalEdge, 8> kMshPyramidEdges{
    {{0, 1}, {0, 3}, {0, 4}, {1, 2}, {1, 4}, {2, 3}, {2, 4}, {3, 4}}};
inline constexpr std::array<LocalEdge, 9> kMshPrismEdges{
    {{0, 1}, {0, 2}, {0, 3}, {1, 2}, {1, 4}, {2, 5}, {3, 4}, {3, 5}, {4, 5}}};
inline constexpr std::array<LocalEdge, 12> kMshHexEdges{
    {{0, 1}, {0, 3}, {0, 4}, {1, 2}, {1, 5}, {2, 3}, {2, 6}, {3, 7}, {4, 5}, {4, 7}, {5, 6}, {6, 7}}};
constexpr std::span<const LocalEdge> msh_edges_of(Block block) {
  switch (block) {
    case Block::Tet: return kMshTetEdges;
    case Block::Pyramid: return kMshPyramidEdges;
    case Block::Prism: return kMshPrismEdges;
    case Block::Hex: return kMshHexEdges;
    default: return edges_of(block);
  }
}

/// The numbers of a section, which look the same in both forms of the format.
class MshNumbers {
 public:
  MshNumbers(Cursor& cursor, bool binary) : cursor_(cursor), binary_(binary) {}
  std::int32_t integer() { return binary_ ? cursor_.read<std::int32_t>() : cursor_.parse<std::int32_t>(); }
  std::uint64_t size() { return binary_ ? cursor_.read<std::uint64_t>() : cursor_.parse<std::uint64_t>(); }
  double real() { return binary_ ? cursor_.read<double>() : cursor_.parse<double>(); }
  Vec3 point() {
    const double x = real(), y = real(), z = real();
    return {x, y, z};
  }
  /// A size of that many items, each of the given numbers, that the rest of the file can hold.
  std::uint64_t count(std::size_t integers, std::size_t sizes_and_reals) {
    const std::uint64_t value = size();
    expect(value, integers, sizes_and_reals);
    return value;
  }
  void expect(std::uint64_t count, std::size_t integers, std::size_t sizes_and_reals) const {
    cursor_.expect(count, binary_ ? 4 * integers + 8 * sizes_and_reals : 2 * (integers + sizes_and_reals));
  }
  const char* at() const { return cursor_.at(); }

 private:
  Cursor& cursor_;
  bool binary_;
};

/// From the node tags of a file, which may have gaps and any order, to point indices.
class NodeTags {
 public:
  /// Puts points into the ascending order of their tags.
  void finish(const InputFile& file, std::vector<std::uint64_t>&& tags, std::vector<Vec3>& points,
              std::vector<ModelEntity>& entities) {
    tags_ = std::move(tags);
    if (!std::is_sorted(tags_.begin(), tags_.end())) sort(points, entities);
    if (std::adjacent_find(tags_.begin(), tags_.end()) != tags_.end())
      file.fail(ErrorCode::InputUnreadable, "two nodes have the same tag");
  }
  std::uint32_t find(std::uint64_t tag) const {
    if (tags_.empty() || tag < tags_.front() || tag > tags_.back()) return 0xffffffffu;
    if (tags_.back() - tags_.front() == tags_.size() - 1) return static_cast<std::uint32_t>(tag - tags_.front());
    const auto place = std::lower_bound(tags_.begin(), tags_.end(), tag);
    return *place == tag ? static_cast<std::uint32_t>(place - tags_.begin()) : 0xffffffffu;
  }

 private:
  void sort(std::vector<Vec3>& points, std::vector<ModelEntity>& entities) {
    std::vector<std::uint32_t> order(tags_.size());
    for (std::uint32_t i = 0; i < order.size(); ++i) order[i] = i;
    std::sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) { return tags_[a] < tags_[b]; });
    const auto permute = [&](auto& array) {
      auto old = std::move(array);
      array.resize(old.size());
      for (std::size_t i = 0; i < order.size(); ++i) array[i] = old[order[i]];
    };
    permute(tags_);
    permute(points);
    permute(entities);
  }
  std::vector<std::uint64_t> tags_;  // ascending
};

/// The part of each element, by Block, and of each point.
struct MshOwners {
  std::array<std::vector<std::uint32_t>, kBlocks> of_elements;
  std::vector<std::uint32_t> of_points;
};
/// Boundary elements and points belong to the lowest part that has a cell with them, or to the first.
MshOwners find_owners(const Mesh& mesh, const MeshParts& parts, const BlockLoop& loop);

/// Entities of parts of a mesh, as $PartitionedEntities lists them.
class MshPartitions {
 public:
  struct Entity {
    std::int32_t parent_dim = -1, parent_tag = 0;
    std::uint32_t part = 0;  ///< the lowest
  };
  bool empty() const { return count_ == 0; }
  std::uint32_t count() const { return count_; }
  void read_section(const InputFile& file, MshNumbers& numbers);
  /// Null for entities of the mesh as a whole.
  const Entity* find(std::int32_t dim, std::int32_t tag) const;

 private:
  std::uint32_t count_ = 0;
  std::array<std::map<std::int32_t, Entity>, 4> entities_;
};

/// The head of a section of data, and where its tags and values follow.
struct MshView {
  std::string name;
  bool on_nodes = false, binary = false;
  std::int64_t step = 0;
  std::size_t components = 1;
  std::uint64_t count = 0;
  Cursor numbers;
};

/// What the tags of views mean.
struct MshCarriers {
  const std::array<std::vector<std::uint64_t>, kBlocks>& element_tags;  ///< by Block
  /// The point of a node, one past the last where another slice has it; nothing where the file has no such node.
  std::function<std::optional<std::size_t>(std::uint64_t)> find_point;
  /// Of a tag that is not among those of elements: whether another slice has a cell of it.
  std::function<bool(std::uint64_t)> is_cell_elsewhere;
};

/// The sections NodeData and ElementData, whose tags have a meaning only once all the rest has been read.
class MshViews {
 public:
  explicit MshViews(const InputFile& file) : file_(file) {}

  /// Reads the head of a section and remembers where its numbers are; goes behind those of a binary file.
  void read_section(Cursor& cursor, bool binary, std::string_view section);

  /// Makes fields of the sections, in their order: one for each name, from the first of its time steps, NaN where the
  /// file has no value. Element data are fields where there is one for a cell at all. Throws InputUnreadable for
  /// unknown nodes, and where a small file asks for fields of an enormous size.
  void add_fields(Mesh& mesh, const MshCarriers& carriers) const;

 private:
  const InputFile& file_;
  std::vector<MshView> views_;
};

}  // namespace tetloom::detail
