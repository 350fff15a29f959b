#include "adapt/transfer/cell_transfer.hpp"

#include <algorithm>
#include <cmath>

#include "core/base/exact_sum.hpp"
#include "core/base/lists.hpp"
#include "tetloom/assert.hpp"
#include "tetloom/tasks.hpp"

namespace tetloom::adapt {
namespace {

constexpr std::size_t kSumGrain = 1 << 12;
constexpr std::size_t kMostSums = 8;           // blocks of tets, each of which has sums for all regions
constexpr std::size_t kManyOverlaps = 1 << 9;  // between two looks at whether to go on
constexpr double kOutside = 1e-9;              // a share that is covered by no more counts as nothing

std::size_t index_in(std::span<const std::uint32_t> regions, std::uint32_t region) {
  return static_cast<std::size_t>(std::ranges::lower_bound(regions, region) - regions.begin());
}

// Ascending.
std::vector<std::uint32_t> regions_of_all(std::span<const std::uint32_t> own, const SharedWork& work) {
  std::vector<std::uint32_t> found;
  for (const std::uint32_t region : own)
    if (found.empty() || found.back() != region) found.push_back(region);
  sort_unique(found);
  found = gather_lists<std::uint32_t>(work.ranks(), found);
  sort_unique(found);
  return found;
}

/// Of some tets: volumes of all regions, and integrals and extremes by region and component.
struct ExactSums {
  std::vector<ExactSum> volumes, integrals;
  std::vector<double> ends;  // of every component minus the least value and the greatest one

  ExactSums(std::size_t regions, std::size_t components)
      : volumes(regions), integrals(regions * components), ends(regions * components * 2, -HUGE_VAL) {}

  void add(std::size_t region, double volume, std::span<const double> values) {
    volumes[region].add(volume);
    for (std::size_t c = 0; c < values.size(); ++c) {
      const std::size_t at = region * values.size() + c;
      integrals[at].add(volume * values[c]);
      ends[at * 2] = std::max(ends[at * 2], -values[c]), ends[at * 2 + 1] = std::max(ends[at * 2 + 1], values[c]);
    }
  }
  void add(const ExactSums& other) {
    for (std::size_t i = 0; i < volumes.size(); ++i) volumes[i].add(other.volumes[i]);
    for (std::size_t i = 0; i < integrals.size(); ++i) integrals[i].add(other.integrals[i]);
    for (std::size_t i = 0; i < ends.size(); ++i) ends[i] = std::max(ends[i], other.ends[i]);
  }
};

ExactSums sum_own(const TetsInRegions& own, const CellValues& cells, std::span<const std::uint32_t> regions,
                  const TaskRunner& runner) {
  const std::size_t count = own.mesh.tets.size(), grain = std::max(kSumGrain, count / kMostSums + 1);
  ExactSums all(regions.size(), cells.components);
  const auto add = [&](std::size_t begin, std::size_t end, ExactSums& sums) {
    for (std::size_t tet = begin; tet < end; ++tet)
      sums.add(index_in(regions, own.regions[tet]), volume_of(corners_of(own.mesh, static_cast<std::uint32_t>(tet))),
               {cells.of(tet), cells.components});
  };
  for (const ExactSums& block : map_blocks(runner, count, grain, all, add)) all.add(block);
  return all;
}

struct Change {
  double factor = 1, shift = 0;
};

Change change_of(const RegionIntegrals& old, const RegionIntegrals& now) {
  const bool one_sign = old.least >= 0 || old.greatest <= 0;
  const double factor = old.integral / now.integral;
  if (one_sign && std::isfinite(factor) && factor > 0) return {factor, 0};
  const double shift = (old.integral - now.integral) / now.volume;
  return {1, std::isfinite(shift) ? shift : 0};
}

}  // namespace

std::span<const RegionIntegrals> SumsByRegion::of(std::uint32_t region) const {
  return std::span(integrals).subspan(index_in(regions, region) * components, components);
}

SumsByRegion sum_cells(const TetsInRegions& own, const CellValues& cells, const SharedWork& work) {
  SumsByRegion result{regions_of_all(own.regions, work), cells.components, {}};
  ExactSums sums(0, 0);
  work.each([&] { sums = sum_own(own, cells, result.regions, work.runner()); });
  work.sum(sums.volumes), work.sum(sums.integrals), work.max(sums.ends);
  for (std::size_t i = 0; i < sums.integrals.size(); ++i)
    result.integrals.push_back({sums.volumes[i / cells.components].value(), sums.integrals[i].value(),
                                -sums.ends[i * 2], sums.ends[i * 2 + 1]});
  return result;
}

void CellAverager::put_means(std::size_t tet, double* values) {
  const TetVerts& v = to_.mesh.tets[tet];
  const auto overlaps = finder_.find(to_.mesh, v, to_.regions[tet],
                                     {places_[v[0]].tet, places_[v[1]].tet, places_[v[2]].tet, places_[v[3]].tet});
  count(overlaps.size() + 1);
  const double covered = finder_.covered();
  if (covered <= kOutside) return take_nearest(to_.regions[tet], values);
  const std::size_t n = from_.components();
  std::fill_n(values, n, 0.0);
  const Corners x = corners_of(to_.mesh.points, v);
  for (const Overlap& overlap : overlaps) {
    const OldTet old = from_[overlap.tet];
    Vec3 moment;  // of the overlap about the centre of the old tet
    if (old.slopes != nullptr) {
      const Vec3 center = center_of(old.corners());
      for (std::size_t i = 0; i < 4; ++i) moment += overlap.moment[i] * (x[i] - center);
    }
    for (std::size_t c = 0; c < n; ++c) {
      values[c] += overlap.share / covered * old.values[c];
      if (old.slopes != nullptr) values[c] += dot(old.slopes[c], moment) / covered;
    }
  }
}

void CellAverager::count(std::size_t overlaps) {
  overlaps_ += overlaps;
  if (overlaps_ < kManyOverlaps) return;
  overlaps_ = 0;
  runner_.check_cancelled();
}

void CellAverager::take_nearest(std::uint32_t region, double* values) {
  const BackgroundTet nearest = finder_.nearest(region);
  for (std::size_t c = 0; c < from_.components(); ++c)
    values[c] = nearest == kNoTet ? before_.of(region)[c].mean() : from_[nearest].values[c];
}

void put_right_cells(const SumsByRegion& before, const SumsByRegion& after, std::span<const std::uint32_t> regions,
                     std::span<double> values, const TaskRunner& runner) {
  const std::size_t n = before.components;
  TETLOOM_ASSERT(values.size() == regions.size() * n && after.components == n);
  std::vector<Change> changes;
  for (std::size_t i = 0; i < after.integrals.size(); ++i)
    changes.push_back(change_of(before.of(after.regions[i / n])[i % n], after.integrals[i]));
  runner.for_blocks(regions.size(), kSumGrain, [&](std::size_t begin, std::size_t end) {
    for (std::size_t tet = begin; tet < end; ++tet) {
      const Change* const change = &changes[index_in(after.regions, regions[tet]) * n];
      for (std::size_t c = 0; c < n; ++c)
        values[tet * n + c] = values[tet * n + c] * change[c].factor + change[c].shift;
    }
  });
}

}  // namespace tetloom::adapt
