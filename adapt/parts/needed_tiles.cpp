#include "adapt/parts/needed_tiles.hpp"

#include <algorithm>

#include "core/base/grain.hpp"

namespace tetloom::adapt {

namespace {

constexpr double kBeside = 0.1;  // of a tet's box
constexpr double kTogether = 4;  // boxes of tets are joined up to so many times the diagonal of one
constexpr std::size_t kVertsOfTile = 16;

// Around a tet, with what lies beside it.
Box3 box_of_tet(const CavityMesh& part, std::size_t tet) {
  Box3 box;
  for (std::size_t i = 0; i < 4; ++i) box.add(part.point(part.mesh.to_vert[tet * 4 + i]));
  const Vec3 beside = kBeside * (box.hi - box.lo);
  box.add(box.lo - beside), box.add(box.hi + beside);
  return box;
}

// Whether it lies at vertices that stay, and so where the part ends.
bool is_at_end(const CavityMesh& part, std::size_t tet) {
  const std::uint32_t* v = &part.mesh.to_vert[tet * 4];
  return (part.to_frozen[v[0]] | part.to_frozen[v[1]] | part.to_frozen[v[2]] | part.to_frozen[v[3]]) != 0;
}

// Those of all tets, or of those where the part ends. Tets that follow each other are mostly neighbours, and asked for
// together.
void mark_tiles(const CavityMesh& part, std::size_t begin, std::size_t end, bool all_tets, const BackgroundTiles& tiles,
                std::span<std::uint8_t> marks) {
  Box3 all;
  for (std::size_t tet = begin; tet < end; ++tet) {
    if (!all_tets && !is_at_end(part, tet)) continue;
    const Box3 box = box_of_tet(part, tet);
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

// Those that have the part's vertices; how many.
std::size_t mark_tiles_of_verts(const CavityMesh& part, const BackgroundTiles& tiles, std::span<std::uint8_t> marks) {
  std::size_t count = 0;
  for (const BackgroundTet hint : part.to_hint) {
    std::uint8_t& mark = marks[tiles.tile_of(hint)];
    count += 1 - mark;
    mark = 1;
  }
  return count;
}

}  // namespace

std::vector<std::uint32_t> needed_tiles(std::span<const PartOfWhole> parts, const BackgroundTiles& tiles,
                                        const TaskRunner& runner) {
  std::vector<std::uint8_t> all(tiles.tile_count(), 0);
  for (const PartOfWhole& part : parts) {
    // Inside of a part tiles have vertices, unless the mesh has become much coarser.
    std::vector<std::uint8_t> of_verts(all.size(), 0);
    const std::size_t count = mark_tiles_of_verts(part.mesh, tiles, of_verts);
    for (std::size_t tile = 0; tile < all.size(); ++tile) all[tile] |= of_verts[tile];
    const bool is_coarse = part.mesh.to_hint.size() < kVertsOfTile * count;
    const auto blocks = map_blocks(runner, part.mesh.mesh.size(), grain_of_tables(part.mesh.mesh.size(), kCopyGrain),
                                   std::vector<std::uint8_t>(),
                                   [&](std::size_t begin, std::size_t end, std::vector<std::uint8_t>& marks) {
                                     marks.resize(all.size(), 0);
                                     mark_tiles(part.mesh, begin, end, is_coarse, tiles, marks);
                                   });
    for (const auto& marks : blocks)
      for (std::size_t tile = 0; tile < all.size(); ++tile) all[tile] |= marks[tile];
  }
  return marked(all);
}

}  // namespace tetloom::adapt
