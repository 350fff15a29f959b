#include <cmath>

#include "adapt/parts/cut_parts.hpp"
#include "adapt/parts/join_parts.hpp"
#include "adapt/parts/needed_tiles.hpp"
#include "adapt/parts/rounds.hpp"
#include "adapt/parts/split_sides.hpp"

namespace tetloom::adapt {

namespace {

// Vertices that were there before, by their numbers in the share; kNone for new ones.
void finish(PartOfWhole& part) {
  const std::size_t given = part.to_whole.size();
  const bool has_grown = part.mesh.mesh.points.size() > given + given / 8;
  part.to_whole.resize(part.mesh.mesh.points.size(), kNone);
  const auto from = part.mesh.renumber(has_grown);
  GrowingArray<std::uint32_t> to_whole;
  to_whole.reserve(from.size());
  for (const std::uint32_t v : from) to_whole.push_back(part.to_whole[v]);
  part.to_whole = std::move(to_whole);
  // Parts wait for the others: what a round begins with is made anew.
  part.mesh.to_quality.release(), part.mesh.vert_to_tet.release();
}

// Adapts the parts that have not been `done`. One that lacks a tile is as it was before.
void adapt_parts(std::span<PartOfWhole> parts, std::uint32_t first, std::span<const double> part_work,
                 const RoundWork& round, std::span<std::uint8_t> done, const TaskRunner& runner) {
  runner.for_each_largest_first(part_work, [&](std::size_t p) {
    if (done[p] != 0) return;
    CavityMesh before;
    if (round.tiles != nullptr) before = parts[p].mesh;
    if (finds(round.tiles, [&] { round.adapt(first + p, parts[p].mesh); })) {
      before = CavityMesh();
      finish(parts[p]);
      done[p] = 1;
    } else {
      parts[p].mesh = std::move(before);
    }
  });
}

void fetch_tiles(std::span<const PartOfWhole> parts, BackgroundTiles& tiles, const SharedWork& work) {
  std::vector<std::uint32_t> needed;
  work.each([&] { needed = needed_tiles(parts, tiles, work.runner()); });
  tiles.fetch_only(std::move(needed), work);
}

}  // namespace

std::size_t adapt_in_parts(WholeMesh& share, ShareLinks& links, Dealing&& dealing, const RoundWork& round,
                           const SharedWork& work) {
  const std::size_t part_count = dealing.work.size();
  RoundShare moved = move_tets(share, links, std::move(dealing.to_part), part_count, work);
  std::uint32_t first = 0;
  while (first < part_count && rank_of_part(first, part_count, work.rank_count()) < work.rank()) ++first;
  std::vector<double> own_work;
  for (std::uint32_t p = first; p < part_count && rank_of_part(p, part_count, work.rank_count()) == work.rank(); ++p)
    own_work.push_back(static_cast<double>(dealing.work[p]));
  std::vector<PartOfWhole> parts;
  work.each([&] {
    parts = cut_parts(moved, first, static_cast<std::uint32_t>(own_work.size()), work.runner());
    work.runner().for_each(parts.size(), [&](std::size_t p) { parts[p].mesh.start(); });
  });
  if (round.tiles != nullptr) fetch_tiles(parts, *round.tiles, work);
  std::size_t split = 0;
  if (part_count > 1 && std::isfinite(round.sides.longest)) split = split_sides(moved, links, parts, round, work);
  std::vector<std::uint8_t> done(parts.size(), 0);
  until_found(round.tiles, work, [&] { adapt_parts(parts, first, own_work, round, done, work.runner()); });
  if (round.tiles != nullptr) round.tiles->drop_fetched();
  share = join_parts(moved, parts, links, work);
  return split;
}

}  // namespace tetloom::adapt
