#include "adapt/parts/needed_tiles.hpp"

#include <algorithm>

#include "core/base/grain.hpp"

namespace tetloom::adapt {

namespace {

constexpr std::size_t kGroup = 8;  // tets that follow each other, whose box is found at once
constexpr double kBeside = 0.05;   // of a group's box
constexpr double kTogether = 3;    // boxes of groups are joined up to so many times the diagonal of one

// Around some tets, with what lies beside them.
Box3 box_of_tets(const CavityMesh& part, std::size_t begin, std::size_t end) {
  Box3 box;
  for (std::size_t i = begin * 4; i < end * 4; ++i) box.add(part.point(part.mesh.to_vert[i]));
  const Vec3 beside = kBeside * (box.hi - box.lo);
  return {box.lo - beside, box.hi + beside};
}

// Tets that follow each other are mostly neighbours, and asked for together.
void mark_tiles(const CavityMesh& part, std::size_t begin, std::size_t end, const BackgroundTiles& tiles,
                std::span<std::uint8_t> marks) {
  Box3 all;
  for (std::size_t first = begin; first < end; first += kGroup) {
    const Box3 box = box_of_tets(part, first, std::min(end, first + kGroup));
    Box3 joined = all;
    joined.add(box);
    if (!all.empty() && joined.diagonal() > kTogether * box.diagonal()) {
      tiles.mark_tiles(all, marks);
      joined = box;
    }
    all = joined;
  }
  if (!all.empty()) tiles.mark_tiles(all, marks);
}

}  // namespace

std::vector<std::uint32_t> needed_tiles(std::span<const PartOfWhole> parts, const BackgroundTiles& tiles,
                                        const TaskRunner& runner) {
  std::vector<std::uint8_t> all(tiles.tile_count(), 0);
  for (const PartOfWhole& part : parts) {
    const auto blocks = map_blocks(runner, part.mesh.mesh.size(), grain_of_tables(part.mesh.mesh.size(), kCopyGrain),
                                   std::vector<std::uint8_t>(),
                                   [&](std::size_t begin, std::size_t end, std::vector<std::uint8_t>& marks) {
                                     marks.resize(all.size(), 0);
                                     mark_tiles(part.mesh, begin, end, tiles, marks);
                                   });
    for (const auto& marks : blocks)
      for (std::size_t tile = 0; tile < all.size(); ++tile) all[tile] |= marks[tile];
  }
  return marked(all);
}

}  // namespace tetloom::adapt
