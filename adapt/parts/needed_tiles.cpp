#include "adapt/parts/needed_tiles.hpp"

#include <algorithm>

#include "core/base/grain.hpp"

namespace tetloom::adapt {

namespace {

constexpr double kBeside = 0.1;  // of a tet's box
constexpr double kTogether = 4;  // boxes of tets are joined up to so many times the diagonal of one

// Around a tet, with what lies beside it.
Box3 box_of_tet(const CavityMesh& part, std::size_t tet) {
  Box3 box;
  for (std::size_t i = 0; i < 4; ++i) box.add(part.point(part.mesh.to_vert[tet * 4 + i]));
  const Vec3 beside = kBeside * (box.hi - box.lo);
  box.add(box.lo - beside), box.add(box.hi + beside);
  return box;
}

// Tets that follow each other are mostly neighbours, and asked for together.
void mark_tiles(const CavityMesh& part, std::size_t begin, std::size_t end, const BackgroundTiles& tiles,
                std::span<std::uint8_t> marks) {
  Box3 all = box_of_tet(part, begin);
  for (std::size_t tet = begin + 1; tet < end; ++tet) {
    const Box3 box = box_of_tet(part, tet);
    Box3 joined = all;
    joined.add(box);
    if (joined.diagonal() > kTogether * box.diagonal()) {
      tiles.mark_tiles(all, marks);
      joined = box;
    }
    all = joined;
  }
  tiles.mark_tiles(all, marks);
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
