#pragma once
// Values on tets, from the mesh as it was to the mesh as it is.
#include <cmath>
#include <cstdint>
#include <span>
#include <vector>

#include "adapt/transfer/old_tets.hpp"
#include "adapt/transfer/overlaps.hpp"
#include "threading/comm/shared_work.hpp"

namespace tetloom::adapt {

/// Tets, and the region of each. Non-owning.
struct TetsInRegions {
  TetView mesh;
  std::span<const std::uint32_t> regions;
};

/// What is known of one component in one region.
struct RegionIntegrals {
  double volume = 0, integral = 0;
  double least = HUGE_VAL, greatest = -HUGE_VAL;

  double mean() const { return volume > 0 ? integral / volume : 0; }
};

/// That of the whole mesh, by region and component.
struct SumsByRegion {
  std::vector<std::uint32_t> regions;  ///< ascending
  std::size_t components = 0;
  std::vector<RegionIntegrals> integrals;

  /// Pre: one of the regions.
  std::span<const RegionIntegrals> of(std::uint32_t region) const;
};

/// Of the tets of all ranks, each of which is given with one of them; exact, so that nothing depends on the ranks. In
/// SharedWork::together.
SumsByRegion sum_cells(const TetsInRegions& own, const CellValues& cells, const SharedWork& work);

/// New values on tets: the mean, over the part of each new tet that lies in its region as it was, of the field there,
/// by exact intersections of tets (Farrell & Maddison 2011; Alauzet & Mehrenberger 2010). Where the meshes cover the
/// same regions, integrals over regions are kept up to round-off, tet by tet. A new tet that lies outside altogether
/// has the value of the nearest tet of its region.
///
/// One finds values for one task at a time; they do not depend on what else it finds. Refers to its arguments.
class CellAverager {
 public:
  /// `before`: sums over all tets of `from`. `places`: of all points of `to`, which may be some of the mesh's tets.
  CellAverager(const OldTets& from, const SumsByRegion& before, const TetsInRegions& to,
               std::span<const BackgroundPlace> places, const TaskRunner& runner)
      : from_(from), before_(before), to_(to), places_(places), runner_(runner), finder_(from) {}

  /// Fills in all components of a new tet. About 0.4 µs per overlap of two tets. Errors: Cancelled; MissingTile where
  /// the old tets lie in tiles.
  void put_means(std::size_t tet, double* values);

 private:
  void count(std::size_t overlaps);
  void take_nearest(std::uint32_t region, double* values);

  const OldTets& from_;
  const SumsByRegion& before_;
  const TetsInRegions to_;
  std::span<const BackgroundPlace> places_;
  const TaskRunner& runner_;
  OverlapFinder finder_;
  std::size_t overlaps_ = 0;  // since it was looked at whether to go on
};

/// Puts right, once per region, what has been lost or gained where a curved side has moved: every component is
/// multiplied by one factor where it has one sign in the region as it was, so that what is zero stays zero and nothing
/// changes sign, else shifted. So integrals are kept up to round-off there too, and constants become what the new
/// volume allows. `regions`, `values`: of some tets; `before`, `after`: sums over all.
void put_right_cells(const SumsByRegion& before, const SumsByRegion& after, std::span<const std::uint32_t> regions,
                     std::span<double> values, const TaskRunner& runner);

}  // namespace tetloom::adapt
