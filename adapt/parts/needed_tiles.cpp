#include "adapt/parts/needed_tiles.hpp"

#include <algorithm>

namespace tetloom::adapt {

namespace {

constexpr std::size_t kAtOnce = 8;    // neighbouring tets that are asked for together
constexpr double kBeside = 0.1;       // of a tet's box
constexpr std::size_t kGrain = 1024;  // such groups

// Around some tets of a part, with what lies beside each of them.
Box3 box_of_tets(const CavityMesh& part, std::size_t begin, std::size_t end) {
  Box3 all;
  for (std::size_t tet = begin; tet < end; ++tet) {
    Box3 box;
    for (std::size_t i = 0; i < 4; ++i) box.add(part.point(part.mesh.to_vert[tet * 4 + i]));
    const Vec3 beside = kBeside * (box.hi - box.lo);
    all.add(box.lo - beside), all.add(box.hi + beside);
  }
  return all;
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
    const std::size_t count = part.mesh.mesh.size(), groups = (count + kAtOnce - 1) / kAtOnce;
    const auto blocks = map_blocks(runner, groups, kGrain, std::vector<std::uint32_t>(),
                                   [&](std::size_t begin, std::size_t end, std::vector<std::uint32_t>& found) {
                                     for (std::size_t i = begin; i < end; ++i)
                                       tiles.find_tiles(box_of_tets(part.mesh, i * kAtOnce,
                                                                    std::min(count, (i + 1) * kAtOnce)),
                                                        found);
                                     sort_unique(found);
                                   });
    for (const auto& found : blocks) needed.insert(needed.end(), found.begin(), found.end());
    sort_unique(needed);
  }
  return needed;
}

}  // namespace tetloom::adapt
