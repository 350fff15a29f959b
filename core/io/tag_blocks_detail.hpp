#pragma once
// Private to core/io: items of a mesh in the blocks by entity that MSH files want.
#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <span>
#include <utility>
#include <vector>

#include "tetloom/host.hpp"

namespace tetloom::detail {

/// Items in blocks by entity tag (0 for those without an entity), in their own order inside a block.
struct TagBlocks {
  std::vector<std::int32_t> tags;     // ascending
  std::vector<std::size_t> begin{0};  // of each block in `order`, and the end of the last
  std::unique_ptr<std::uint32_t[]> order;

  std::size_t size() const { return begin.back(); }
  std::span<const std::uint32_t> items(std::size_t block) const {
    return {order.get() + begin[block], order.get() + begin[block + 1]};
  }
};

/// How many items of each tag a stretch of the mesh has, and then where its next one goes.
using TagPlaces = std::map<std::int32_t, std::size_t>;

/// Turns the counts of all stretches into places, tag by tag and then stretch by stretch. `order` has the length that
/// it needs.
inline TagBlocks lay_out_tags(std::vector<TagPlaces>& stretches) {
  TagPlaces sizes;
  for (const TagPlaces& places : stretches)
    for (const auto& [tag, size] : places) sizes[tag] += size;
  TagBlocks blocks;
  for (auto& [tag, place] : sizes) {
    const std::size_t size = std::exchange(place, blocks.begin.back());
    blocks.tags.push_back(tag);
    blocks.begin.push_back(blocks.begin.back() + size);
  }
  for (TagPlaces& places : stretches)
    for (auto& [tag, place] : places) {
      std::size_t& next = sizes.at(tag);
      next += std::exchange(place, next);
    }
  blocks.order = std::make_unique_for_overwrite<std::uint32_t[]>(blocks.size());
  return blocks;
}

/// `tag_of(i)` gives the tag of item i, or -1 to leave it out; it may be called several times, and by several threads
/// at once.
template <class TagOf>
TagBlocks make_tag_blocks(std::size_t count, const BlockLoop& loop, const TagOf& tag_of) {
  constexpr std::size_t kGrain = std::size_t{1} << 16;
  const auto for_each_place = [&](std::size_t begin, std::size_t end, TagPlaces& places, const auto& body) {
    auto last = places.end();  // items of an entity tend to follow each other
    for (std::size_t i = begin; i < end; ++i) {
      const std::int32_t tag = tag_of(i);
      if (tag < 0) continue;
      if (last == places.end() || last->first != tag) last = places.try_emplace(tag, 0).first;
      body(last->second, i);
    }
  };
  std::vector<TagPlaces> stretches =
      map_blocks(loop, count, kGrain, TagPlaces(), [&](std::size_t begin, std::size_t end, TagPlaces& places) {
        for_each_place(begin, end, places, [](std::size_t& size, std::size_t) { ++size; });
      });
  TagBlocks blocks = lay_out_tags(stretches);
  loop.for_blocks(count, kGrain, [&](std::size_t begin, std::size_t end) {
    for_each_place(begin, end, stretches[begin / kGrain],
                   [&](std::size_t& place, std::size_t i) { blocks.order[place++] = static_cast<std::uint32_t>(i); });
  });
  return blocks;
}

}  // namespace tetloom::detail
