#include "mesher/parts/part_surface.hpp"

#include <algorithm>
#include <array>

namespace tetloom::parts {

namespace {

constexpr std::size_t kBlock = 4096;

}  // namespace

struct PartSurface::Pair {
  PartId part;
  std::uint32_t item;
};

// In the order of the items, once each.
PartSurface::Lists PartSurface::deal(std::span<const std::vector<Pair>> block_to_pairs, std::size_t part_count) const {
  std::vector<std::vector<std::uint32_t>> part_to_items(part_count);
  for (const auto& pairs : block_to_pairs)
    for (const Pair& pair : pairs) part_to_items[pair.part.value].push_back(pair.item);
  Lists lists;
  lists.first.push_back(0);
  for (auto& items : part_to_items) {
    if (!std::is_sorted(items.begin(), items.end())) std::sort(items.begin(), items.end());
    lists.items.insert(lists.items.end(), items.begin(), std::unique(items.begin(), items.end()));
    lists.first.push_back(static_cast<std::uint32_t>(lists.items.size()));
    items = {};
  }
  return lists;
}

PartSurface::PartSurface(const volume::Complex& complex, const SizeField& sizes, const Decomposition& decomposition,
                         double reach, const TaskRunner& runner) {
  // Blocks find their pairs side by side; they are dealt to the parts in the order of the blocks.
  std::vector<std::vector<Pair>> block_to_pairs;
  const auto collect = [&](std::size_t count, const auto& find) {
    const std::size_t before = block_to_pairs.size();
    block_to_pairs.resize(before + (count + kBlock - 1) / kBlock);
    runner.for_blocks(count, kBlock, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i)
        find(static_cast<std::uint32_t>(i), block_to_pairs[before + begin / kBlock]);
    });
  };
  const auto find_parts = [&](std::uint32_t point, auto&& visit) {
    const Vec3& x = complex.points[point];
    const double margin = reach * sizes.size_at(x);
    const Vec3 around{margin, margin, margin};
    decomposition.for_each_in({x - around, x + around}, visit);
  };
  point_to_owner_.resize(complex.points.size());
  collect(complex.points.size(), [&](std::uint32_t point, std::vector<Pair>& pairs) {
    point_to_owner_[point] = decomposition.owner_of(complex.points[point]);
    find_parts(point, [&](PartId part) { pairs.push_back({part, point}); });
  });
  collect(complex.tri_to_vert.size(), [&](std::uint32_t triangle, std::vector<Pair>& pairs) {
    const auto& verts = complex.tri_to_vert[triangle];
    for (const std::uint32_t v : verts)
      for (const std::uint32_t other : verts)
        if (owner_of(other) != owner_of(v)) pairs.push_back({owner_of(v), other});
  });
  points_ = deal(block_to_pairs, decomposition.part_count());
  block_to_pairs.clear();
  collect(complex.tri_to_vert.size(), [&](std::uint32_t triangle, std::vector<Pair>& pairs) {
    const auto& [a, b, c] = complex.tri_to_vert[triangle];
    const auto add = [&](PartId part) {
      const auto known = points_of(part);
      for (const std::uint32_t v : {a, b, c})
        if (!std::binary_search(known.begin(), known.end(), v)) return;
      pairs.push_back({part, triangle});
    };
    find_parts(a, add);
    add(owner_of(b)), add(owner_of(c));  // where that of the first is farther away
  });
  triangles_ = deal(block_to_pairs, decomposition.part_count());
}

}  // namespace tetloom::parts
