#include "adapt/parts/lent_parts.hpp"

#include <algorithm>
#include <numeric>
#include <set>
#include <utility>

namespace tetloom::adapt {

namespace {

// Microseconds, fitted to 508 parts of two meshes: by kind of round off by .14 to .27 of what they take.
constexpr double kPerTet = 0.02, kPerActiveTet = 0.2, kPerMovableTet = 0.67, kPerLongEdge = 3.35, kPerShortEdge = 5.7;
constexpr double kWayOfTet = 0.2;
constexpr double kMovable = 0.78;  // cubed mean ratio: vertices of tets below move
constexpr double kShort = 0.65;
constexpr std::uint32_t kOneOf = 8;   // tets is looked at
constexpr double kEvenEnough = 1.03;  // the most work of a rank beside the mean

double work_of_tet(const CavityMesh& part, std::uint32_t tet, double longest) {
  if (part.mesh.is_dead(tet)) return 0;
  if (!part.is_active(tet)) return kPerTet;
  double work = kPerActiveTet;
  if (part.to_quality[tet] < kMovable) work += kPerMovableTet;
  const std::uint32_t* verts = part.verts(tet);
  for (int i = 1; i < 4; ++i) {
    for (int j = 0; j < i; ++j) {
      const double length = part.length_of(verts[i], verts[j]);
      if (length > longest) work += kPerLongEdge;
      if (length < kShort) work += kPerShortEdge;
    }
  }
  return work;
}

}  // namespace

PartLoad load_of(const CavityMesh& part, double longest) {
  PartLoad load;
  const auto count = static_cast<std::uint32_t>(part.mesh.size());
  for (std::uint32_t tet = 0; tet < count; tet += kOneOf) load.work += kOneOf * work_of_tet(part, tet, longest);
  load.way = kWayOfTet * count;
  return load;
}

std::vector<int> lend_parts(std::span<const PartLoad> loads, int ranks) {
  std::vector<int> to_rank;
  std::vector<std::vector<std::uint32_t>> own(static_cast<std::size_t>(ranks));
  std::vector<double> sums(own.size(), 0);
  for (std::uint32_t p = 0; p < loads.size(); ++p) {
    const int rank = to_rank.emplace_back(rank_of_part(p, loads.size(), ranks));
    own[static_cast<std::size_t>(rank)].push_back(p), sums[static_cast<std::size_t>(rank)] += loads[p].work;
  }
  const double mean = std::accumulate(sums.begin(), sums.end(), 0.0) / ranks;
  std::set<std::pair<double, std::size_t>> by_work;
  for (std::size_t r = 0; r < sums.size(); ++r) by_work.emplace(sums[r], r);
  while (by_work.size() > 1) {
    const auto [least, to] = *by_work.begin();
    const auto [most, from] = *by_work.rbegin();
    if (most <= kEvenEnough * mean) break;
    std::size_t best = own[from].size();
    double reached = most;
    for (std::size_t i = 0; i < own[from].size(); ++i) {
      const PartLoad& load = loads[own[from][i]];
      const double larger = std::max(most - load.work + load.way, least + load.work + load.way);
      if (larger < reached) reached = larger, best = i;
    }
    if (best == own[from].size()) break;
    const std::uint32_t part = own[from][best];
    own[from].erase(own[from].begin() + static_cast<std::ptrdiff_t>(best));
    to_rank[part] = static_cast<int>(to);
    by_work.erase({least, to}), by_work.erase({most, from});
    by_work.emplace(least + loads[part].work + loads[part].way, to);
    by_work.emplace(most - loads[part].work + loads[part].way, from);
  }
  return to_rank;
}

LentParts::LentParts(std::span<PartOfWhole> own, std::uint32_t first, std::size_t part_count, double longest,
                     const SharedWork& work)
    : own_(own), first_(first), work_(work) {
  const std::vector<Bytes> given = work.all_gather([&](MessageWriter& writer) {
    std::vector<PartLoad> loads(own.size());
    work.runner().for_each(own.size(), [&](std::size_t p) { loads[p] = load_of(own[p].mesh, longest); });
    writer.put_array<PartLoad>(loads);
  });
  work.each([&] {
    loads_ = joined_lists<PartLoad>(given);
    to_rank_ = lend_parts(loads_, work.rank_count());
    for (std::uint32_t p = 0; p < part_count; ++p) {
      const auto at = static_cast<std::size_t>(to_rank_[p]), self = static_cast<std::size_t>(work.rank());
      if (home_of(p) == self && at != self) lent_.push_back(p);
      if (home_of(p) != self && at == self) borrowed_.push_back({p, {}});
    }
  });
}

// What is sent takes the room of what it was. Parts of one rank follow each other by number, there and back.
std::vector<PartAtWork> LentParts::lend() {
  std::vector<Bytes> given = work_.exchange([&](std::span<MessageWriter> to) {
    for (const std::uint32_t number : lent_) {
      put_part(own_[number - first_], to[static_cast<std::size_t>(to_rank_[number])]);
      own_[number - first_] = PartOfWhole();
    }
  });
  work_.each([&] {
    for (std::size_t i = 0, next = 0; i < borrowed_.size(); i = next) {
      Bytes& bytes = given[home_of(borrowed_[i].number)];
      MessageReader reader(bytes);
      for (next = i; next < borrowed_.size() && home_of(borrowed_[next].number) == home_of(borrowed_[i].number); ++next)
        borrowed_[next].part = get_part_of_whole(reader);
      bytes = Bytes();
    }
  });
  std::vector<PartAtWork> here;
  for (std::uint32_t p = 0; p < own_.size(); ++p)
    if (to_rank_[first_ + p] == work_.rank()) here.push_back({&own_[p], first_ + p, loads_[first_ + p].work});
  for (Borrowed& one : borrowed_) here.push_back({&one.part, one.number, loads_[one.number].work});
  std::ranges::sort(here, {}, &PartAtWork::number);
  return here;
}

void LentParts::give_back() {
  const std::vector<Bytes> given = work_.exchange([&](std::span<MessageWriter> to) {
    for (Borrowed& one : borrowed_) {
      put_part(one.part, to[home_of(one.number)]);
      one.part = PartOfWhole();
    }
  });
  work_.each([&] {
    std::vector<MessageReader> readers(given.begin(), given.end());
    for (const std::uint32_t number : lent_)
      own_[number - first_] = get_part_of_whole(readers[static_cast<std::size_t>(to_rank_[number])]);
  });
}

}  // namespace tetloom::adapt
