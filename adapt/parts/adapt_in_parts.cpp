#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <optional>

#include "adapt/parts/cut_parts.hpp"
#include "adapt/parts/join_parts.hpp"
#include "adapt/parts/lent_parts.hpp"
#include "adapt/parts/needed_tiles.hpp"
#include "adapt/parts/rounds.hpp"
#include "adapt/parts/split_sides.hpp"
#include "threading/runtime/pausable.hpp"

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

// Some of a rank's parts, which it adapts as far as the tiles at hand go.
class PartsUnderWay {
 public:
  PartsUnderWay(std::span<const PartAtWork> parts, const RoundWork& round, const TaskRunner& runner)
      : parts_(parts), round_(round), runner_(runner), under_way_(parts.size()), done_(parts.size(), 0) {
    for (const PartAtWork& one : parts) work_.push_back(one.work);
  }

  /// Lets all that have not ended begin or go on.
  void go_on() {
    runner_.for_each_largest_first(work_, [&](std::size_t p) {
      if (done_[p] == 0) done_[p] = goes_to_end(p) ? 1 : 0;
    });
  }

 private:
  // A part waits where it lacks a tile.
  bool goes_to_end(std::size_t p) {
    PartOfWhole& part = *parts_[p].part;
    const auto adapt = [this, &part, number = parts_[p].number] { round_.adapt(number, part.mesh); };
    if (round_.tiles == nullptr) {
      adapt();
    } else {
      if (!under_way_[p]) under_way_[p] = std::make_unique<Pausable>(adapt);
      if (!under_way_[p]->resume()) return false;
      under_way_[p].reset();
    }
    finish(part);
    return true;
  }

  std::span<const PartAtWork> parts_;
  const RoundWork& round_;
  const TaskRunner& runner_;
  std::vector<double> work_;
  std::vector<std::unique_ptr<Pausable>> under_way_;
  std::vector<std::uint8_t> done_;
};

// How a rank goes through its parts, and the tiles that they need: some at a time, which need three quarters of what
// the rank is home to, about. All ranks do so equally often, and have about as much to do each time.
class Batches {
 public:
  Batches(std::span<const PartAtWork> parts, BackgroundTiles* tiles, const SharedWork& work)
      : parts_(parts), tiles_(tiles), work_(work), begins_{0, parts.size()} {
    if (tiles == nullptr) return;
    work.each([&] {
      for (const PartAtWork& one : parts) needed_.push_back(needed_tiles({one.part, 1}, *tiles, work.runner()));
    });
    std::array<double, 1> most{static_cast<double>(wanted())};
    work.max(most);
    cut(static_cast<std::size_t>(most[0]));
  }

  std::size_t count() const { return begins_.size() - 1; }
  std::span<const PartAtWork> parts(std::size_t batch) const {
    return parts_.subspan(begins_[batch], begins_[batch + 1] - begins_[batch]);
  }
  /// Has the tiles of a batch at hand, and no others. In together.
  void fetch(std::size_t batch) const {
    if (tiles_ != nullptr) tiles_->fetch_only(tiles_of(begins_[batch], begins_[batch + 1]), work_);
  }

 private:
  std::vector<std::uint32_t> tiles_of(std::size_t first, std::size_t last) const {
    std::vector<std::uint8_t> marks(tiles_->tile_count(), 0);
    for (std::size_t p = first; p < last; ++p)
      for (const std::uint32_t tile : needed_[p]) marks[tile] = 1;
    return marked(marks);
  }

  // Each leaves something to do for all threads.
  std::size_t wanted() const {
    const auto most = parts_.size() / static_cast<std::size_t>(work_.runner().threads());
    const double share = static_cast<double>(tiles_->tile_count()) / work_.rank_count();
    const double needed = static_cast<double>(tiles_of(0, parts_.size()).size());
    constexpr double kOfShare = 0.75;
    return std::clamp<std::size_t>(static_cast<std::size_t>(needed / share / kOfShare + 0.5), 1,
                                   std::max<std::size_t>(1, most));
  }

  // So that batches are alike in work, for the ranks wait for each other, and in tiles, for these take memory.
  void cut(std::size_t count) {
    double work = 0, tiles = 0;
    for (std::size_t p = 0; p < parts_.size(); ++p)
      work += parts_[p].work, tiles += static_cast<double>(needed_[p].size());
    begins_.assign(count + 1, parts_.size());
    begins_[0] = 0;
    double before = 0;
    for (std::size_t p = 0, batch = 1; p < parts_.size(); ++p) {
      const double share = 0.5 * parts_[p].work / std::max(work, 1e-300) +
                           0.5 * static_cast<double>(needed_[p].size()) / std::max(tiles, 1.0);
      // A part goes where its middle is.
      while (batch < count && (before + 0.5 * share) * static_cast<double>(count) >= static_cast<double>(batch))
        begins_[batch++] = p;
      before += share;
    }
  }

  std::span<const PartAtWork> parts_;
  BackgroundTiles* tiles_;
  const SharedWork& work_;
  std::vector<std::size_t> begins_;                 // of each batch, and the end
  std::vector<std::vector<std::uint32_t>> needed_;  // by each part
};

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
  std::size_t split = 0;
  if (part_count > 1 && std::isfinite(round.sides.longest)) split = split_sides(moved, links, parts, round, work);
  std::optional<LentParts> lent;
  std::vector<PartAtWork> at_work;
  if (work.rank_count() > 1) {
    at_work = lent.emplace(parts, first, part_count, round.sides.longest, work).lend();
  } else {
    for (std::uint32_t p = 0; p < parts.size(); ++p) at_work.push_back({&parts[p], first + p, own_work[p]});
  }
  const Batches batches(at_work, round.tiles, work);
  for (std::size_t batch = 0; batch < batches.count(); ++batch) {
    batches.fetch(batch);
    PartsUnderWay under_way(batches.parts(batch), round, work.runner());
    until_found(round.tiles, work, [&] { under_way.go_on(); });
  }
  if (round.tiles != nullptr) round.tiles->drop_fetched();
  if (lent) lent->give_back();
  share = join_parts(moved, parts, links, work);
  return split;
}

}  // namespace tetloom::adapt
