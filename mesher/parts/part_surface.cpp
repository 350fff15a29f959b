#include "mesher/parts/part_surface.hpp"

#include <algorithm>
#include <array>

namespace tetloom::parts {

namespace {

constexpr std::size_t kBlock = 4096;

struct Pair {
  PartId part;
  std::uint32_t item;
};

}  // namespace

PartSurface::PartSurface(const volume::Complex& complex, const SizeField& sizes, const Decomposition& decomposition,
                         double reach, const TaskRunner& runner) {
  const std::size_t part_count = decomposition.part_count();
  // Blocks find their pairs side by side; they are dealt to the parts in the order of the blocks.
  const auto collect = [&](std::size_t count, const auto& find) {
    std::vector<std::vector<Pair>> block_to_pairs((count + kBlock - 1) / kBlock);
    runner.for_blocks(count, kBlock, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) find(static_cast<std::uint32_t>(i), block_to_pairs[begin / kBlock]);
    });
    Lists lists;
    lists.first.assign(part_count + 1, 0);
    for (const auto& pairs : block_to_pairs)
      for (const Pair& pair : pairs) ++lists.first[pair.part.value + 1];
    for (std::size_t p = 0; p < part_count; ++p) lists.first[p + 1] += lists.first[p];
    lists.items.resize(lists.first.back());
    std::vector<std::uint32_t> next(lists.first.begin(), lists.first.end() - 1);
    for (const auto& pairs : block_to_pairs)
      for (const Pair& pair : pairs) lists.items[next[pair.part.value]++] = pair.item;
    return lists;
  };
  const auto find_parts = [&](std::uint32_t point, auto&& visit) {
    const Vec3& x = complex.points[point];
    const double margin = reach * sizes.size_at(x);
    const Vec3 around{margin, margin, margin};
    decomposition.for_each_in({x - around, x + around}, visit);
  };
  point_to_owner_.resize(complex.points.size());
  points_ = collect(complex.points.size(), [&](std::uint32_t point, std::vector<Pair>& pairs) {
    point_to_owner_[point] = decomposition.owner_of(complex.points[point]);
    find_parts(point, [&](PartId part) { pairs.push_back({part, point}); });
  });
  triangles_ = collect(complex.tri_to_vert.size(), [&](std::uint32_t triangle, std::vector<Pair>& pairs) {
    const auto& [a, b, c] = complex.tri_to_vert[triangle];
    find_parts(a, [&](PartId part) {
      bool knows_all = true;
      for (const std::uint32_t v : {b, c}) {
        bool knows = false;
        find_parts(v, [&](PartId other) { knows |= other == part; });
        knows_all &= knows;
      }
      if (knows_all) pairs.push_back({part, triangle});
    });
  });
}

}  // namespace tetloom::parts
