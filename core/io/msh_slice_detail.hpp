#pragma once
// Private to core/io: what a reader of an MSH file knows of the slice that it keeps.
#include <algorithm>
#include <cstdint>

#include "core/io/slice_filter_detail.hpp"

namespace tetloom::detail {

/// Tags that have no gaps, if none is there twice.
struct TagRange {
  std::uint64_t first = 0, last = 0, count = 0;

  void add(std::uint64_t tag) {
    first = count == 0 ? tag : std::min(first, tag), last = std::max(last, tag);
    ++count;
  }
  bool has_no_gaps() const { return count > 0 && last - first == count - 1; }
  bool has(std::uint64_t tag) const { return tag - first < count; }
};

/// A slice of a file whose nodes and tets have tags without gaps. Sections are read three times: to count, for the
/// tets, and for what these have.
struct MshSlice {
  SliceFilter& filter;
  bool counts = true;  ///< the first time
  TagRange nodes, tets;
  const char *nodes_at = nullptr, *elements_at = nullptr;  ///< the two sections

  /// After the first time.
  void end_counts() {
    counts = false;
    if (!nodes.has_no_gaps() || !tets.has_no_gaps()) filter.set_unfit();
    filter.set_points(nodes.count), filter.expect(Block::Tet, tets.count);
  }
  /// Of a node, among those of the file; none for an unknown tag.
  std::uint32_t number_of(std::uint64_t tag) const {
    return nodes.has(tag) ? static_cast<std::uint32_t>(tag - nodes.first) : kNone;
  }
  bool keeps_node(std::uint64_t tag) const { return !counts && filter.keeps_point(tag - nodes.first); }
  /// Counts the element as well, where it is time for that.
  template <class Element>
  bool keeps(std::uint64_t tag, const Element& element, Block block) {
    if (counts && block == Block::Tet) tets.add(tag);
    if (counts || !filter.wants(block)) return false;
    if (block == Block::Tet) return filter.keeps_tet(tag - tets.first);
    filter.expect(block, 1);
    return filter.keeps(element);
  }
};

}  // namespace tetloom::detail
