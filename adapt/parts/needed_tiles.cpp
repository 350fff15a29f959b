#include "adapt/parts/needed_tiles.hpp"

#include <algorithm>

namespace tetloom::adapt {

namespace {

constexpr double kBeside = 0.1;   // of a tet's box
constexpr double kTogether = 2;   // boxes of tets are joined up to so many times the diagonal of one
constexpr std::size_t kGrain = std::size_t{1} << 12;

// Around a tet, with what lies beside it.
Box3 box_of_tet(const CavityMesh& part, std::size_t tet) {
  Box3 box;
  for (std::size_t i = 0; i < 4; ++i) box.add(part.point(part.mesh.to_vert[tet * 4 + i]));
  const Vec3 beside = kBeside * (box.hi - box.lo);
  box.add(box.lo - beside), box.add(box.hi + beside);
  return box;
}

// Tets that follow each other are mostly neighbours, and asked for together.
void find_tiles(const CavityMesh& part, std::size_t begin, std::size_t end, const BackgroundTiles& tiles,
                std::vector<std::uint32_t>& found) {
  Box3 all = box_of_tet(part, begin);
  for (std::size_t tet = begin + 1; tet < end; ++tet) {
    const Box3 box = box_of_tet(part, tet);
    Box3 joined = all;
    joined.add(box);
    if (joined.diagonal() > kTogether * box.diagonal()) {
      tiles.find_tiles(all, found);
      joined = box;
    }
    all = joined;
  }
  tiles.find_tiles(all, found);
}

void sort_unique(std::vector<std::uint32_t>& tiles) {
  std::ranges::sort(tiles);
  tiles.erase(std::unique(tiles.begin(), tiles.end()), tiles.end());
}

}  // namespace

std::vector<std::uint32_t> needed_tiles(std::span<const PartOfWhole> parts, const BackgroundTiles& tiles,
                                        const TaskRunner& runner) {
  std::vector<std::uint32_t> needed;
  for (const PartOfWhole& part : parts) {
    const auto blocks = map_blocks(runner, part.mesh.mesh.size(), kGrain, std::vector<std::uint32_t>(),
                                   [&](std::size_t begin, std::size_t end, std::vector<std::uint32_t>& found) {
                                     find_tiles(part.mesh, begin, end, tiles, found);
                                     sort_unique(found);
                                   });
    for (const auto& found : blocks) needed.insert(needed.end(), found.begin(), found.end());
    sort_unique(needed);
  }
  return needed;
}

}  // namespace tetloom::adapt
