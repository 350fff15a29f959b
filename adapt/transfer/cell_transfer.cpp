#include "adapt/transfer/cell_transfer.hpp"

#include <algorithm>
#include <cmath>

#include "adapt/transfer/overlaps.hpp"
#include "core/base/lists.hpp"
#include "tetloom/assert.hpp"
#include "tetloom/tasks.hpp"

namespace tetloom::adapt {
namespace {

constexpr std::size_t kGrain = 1 << 8;
constexpr std::size_t kSumGrain = 1 << 12;
constexpr std::size_t kManyOverlaps = 1 << 9;  // between two looks at whether to go on
constexpr double kOutside = 1e-9;              // a share that is covered by no more counts as nothing

/// The regions of the mesh as it was, ascending.
class RegionNames {
 public:
  explicit RegionNames(std::span<const std::uint32_t> regions) {
    for (const std::uint32_t region : regions)
      if (names_.empty() || names_.back() != region) names_.push_back(region);
    sort_unique(names_);
  }
  std::size_t size() const { return names_.size(); }
  std::size_t index(std::uint32_t region) const {
    return static_cast<std::size_t>(std::lower_bound(names_.begin(), names_.end(), region) - names_.begin());
  }

 private:
  std::vector<std::uint32_t> names_;
};

/// Per region and component.
std::vector<RegionIntegrals> sums_over(const RegionNames& names, const TetsInRegions& tets, const CellValues& cells,
                                       const TaskRunner& runner) {
  const std::size_t n = cells.components;
  const std::vector<RegionIntegrals> blank(names.size() * n);
  const auto add_block = [&](std::size_t begin, std::size_t end, std::vector<RegionIntegrals>& sums) {
    for (std::size_t tet = begin; tet < end; ++tet) {
      const double volume = volume_of(corners_of(tets.mesh, static_cast<std::uint32_t>(tet)));
      RegionIntegrals* const of_region = &sums[names.index(tets.regions[tet]) * n];
      for (std::size_t c = 0; c < n; ++c) {
        const double value = cells.of(tet)[c];
        of_region[c].add({volume, volume * value, value, value});
      }
    }
  };
  std::vector<RegionIntegrals> sums = blank;
  for (const auto& block : map_blocks(runner, tets.mesh.tets.size(), kSumGrain, blank, add_block))
    for (std::size_t i = 0; i < sums.size(); ++i) sums[i].add(block[i]);
  return sums;
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

class CellTransfer {
 public:
  CellTransfer(const CellSource& from, const TetsInRegions& to, const TaskRunner& runner)
      : from_(from.mesh),
        from_regions_(from.regions),
        cells_(from.cells),
        to_(to),
        runner_(runner),
        names_(from.regions) {
    TETLOOM_ASSERT(from_regions_.size() == from_.mesh().tets.size() && to.regions.size() == to.mesh.tets.size());
    TETLOOM_ASSERT(cells_.values.size() == from_regions_.size() * cells_.components);
    before_ = sums_over(names_, {from_.mesh(), from_regions_}, cells_, runner_);
  }

  std::vector<double> average_all(std::span<const BackgroundPlace> places, CellReconstruction shape) {
    TETLOOM_ASSERT(places.size() == to_.mesh.points.size());
    if (shape == CellReconstruction::Linear) slopes_ = limited_slopes(from_, from_regions_, cells_, runner_);
    std::vector<double> values(to_.mesh.tets.size() * cells_.components);
    runner_.for_blocks(to_.mesh.tets.size(), kGrain, [&](std::size_t begin, std::size_t end) {
      OverlapFinder finder(from_, from_regions_);
      std::size_t overlaps = 0;
      for (std::size_t tet = begin; tet < end; ++tet) {
        overlaps += average(tet, places, finder, &values[tet * cells_.components]);
        if (overlaps < kManyOverlaps) continue;
        overlaps = 0;
        runner_.check_cancelled();
      }
    });
    return values;
  }

 private:
  // The mean over what of a new tet lies in its region as it was. Returns the number of overlaps.
  std::size_t average(std::size_t tet, std::span<const BackgroundPlace> places, OverlapFinder& finder,
                      double* values) const {
    const TetVerts& v = to_.mesh.tets[tet];
    const auto overlaps = finder.find(to_.mesh, v, to_.regions[tet],
                                      {places[v[0]].tet, places[v[1]].tet, places[v[2]].tet, places[v[3]].tet});
    const std::size_t n = cells_.components;
    if (finder.covered() <= kOutside) {
      take_nearest(tet, finder, values);
      return 1;
    }
    const Corners x = corners_of(to_.mesh, static_cast<std::uint32_t>(tet));
    for (const Overlap& overlap : overlaps) {
      Vec3 moment;  // of the overlap about the centre of the old tet
      if (!slopes_.empty()) {
        const Vec3 center = center_of(corners_of(from_.mesh(), overlap.tet));
        for (std::size_t i = 0; i < 4; ++i) moment += overlap.moment[i] * (x[i] - center);
      }
      for (std::size_t c = 0; c < n; ++c) {
        values[c] += overlap.share / finder.covered() * cells_.of(overlap.tet)[c];
        if (!slopes_.empty()) values[c] += dot(slopes_[overlap.tet * n + c], moment) / finder.covered();
      }
    }
    return overlaps.size();
  }

  void take_nearest(std::size_t tet, OverlapFinder& finder, double* values) const {
    const std::uint32_t nearest = finder.nearest(to_.regions[tet]);
    const std::size_t region = names_.index(to_.regions[tet]);
    for (std::size_t c = 0; c < cells_.components; ++c)
      values[c] = nearest == kNone ? before_[region * cells_.components + c].mean() : cells_.of(nearest)[c];
  }

  const BackgroundMesh& from_;
  std::span<const std::uint32_t> from_regions_;
  CellValues cells_;
  const TetsInRegions& to_;
  const TaskRunner& runner_;
  RegionNames names_;
  std::vector<RegionIntegrals> before_;
  std::vector<Vec3> slopes_;  ///< none where tets have constants
};

}  // namespace

std::vector<double> average_cells(const CellSource& from, const TetsInRegions& to,
                                  std::span<const BackgroundPlace> places, CellReconstruction shape,
                                  const TaskRunner& runner) {
  return CellTransfer(from, to, runner).average_all(places, shape);
}

std::vector<RegionIntegrals> sum_cells(const CellSource& from, const TetsInRegions& to, std::span<const double> values,
                                       const TaskRunner& runner) {
  return sums_over(RegionNames(from.regions), to, {values, from.cells.components}, runner);
}

void put_right_cells(const CellSource& from, std::span<const RegionIntegrals> before,
                     std::span<const RegionIntegrals> after, std::span<const std::uint32_t> regions,
                     std::span<double> values, const TaskRunner& runner) {
  const std::size_t n = from.cells.components;
  TETLOOM_ASSERT(values.size() == regions.size() * n && before.size() == after.size());
  const RegionNames names(from.regions);
  std::vector<Change> changes;
  for (std::size_t i = 0; i < after.size(); ++i) changes.push_back(change_of(before[i], after[i]));
  runner.for_blocks(regions.size(), kSumGrain, [&](std::size_t begin, std::size_t end) {
    for (std::size_t tet = begin; tet < end; ++tet) {
      const Change* const change = &changes[names.index(regions[tet]) * n];
      for (std::size_t c = 0; c < n; ++c)
        values[tet * n + c] = values[tet * n + c] * change[c].factor + change[c].shift;
    }
  });
}

std::vector<double> transfer_cells(const CellSource& from, const TetsInRegions& to,
                                   std::span<const BackgroundPlace> places, CellReconstruction shape,
                                   const TaskRunner& runner) {
  std::vector<double> values = average_cells(from, to, places, shape, runner);
  const auto before = sum_cells(from, {from.mesh.mesh(), from.regions}, from.cells.values, runner);
  put_right_cells(from, before, sum_cells(from, to, values, runner), to.regions, values, runner);
  return values;
}

}  // namespace tetloom::adapt
