#pragma once
// Values on tets, from the mesh as it was to the mesh as it is.
#include <algorithm>
#include <cmath>
#include <span>
#include <vector>

#include "adapt/metric/background.hpp"
#include "adapt/transfer/cell_slopes.hpp"
#include "tetloom/adapt.hpp"
#include "tetloom/tasks.hpp"

namespace tetloom::adapt {

/// Tets, and the region of each. Non-owning.
struct TetsInRegions {
  TetView mesh;
  std::span<const std::uint32_t> regions;
};

/// Values before, `regions` those of the tets of `mesh`. Non-owning. Pre: sizes fit, all values are finite.
struct CellSource {
  const BackgroundMesh& mesh;
  std::span<const std::uint32_t> regions;
  CellValues cells;
};

/// New values, as many components as before: the mean, over the part of each new tet that lies in its region as it was,
/// of the field there, by exact intersections of tets (Farrell & Maddison 2011; Alauzet & Mehrenberger 2010). Where the
/// meshes cover the same regions, integrals over regions are kept up to round-off, tet by tet.
///
/// Where they do not, because a curved side has moved, a new tet that lies outside altogether has the value of the
/// nearest tet of its region, and then every component is put right once per region: multiplied by one factor where it
/// has one sign in the region as it was, so that what is zero stays zero and nothing changes sign, else shifted. So
/// integrals are kept up to round-off there too, and constants become what the new volume allows.
///
/// `places`: a tet of `from` near every point of `to`. Pre: sizes fit. The values do not depend on threads. Errors:
/// Cancelled. About 0.4 µs per overlap of two tets and 1 µs per old one.
std::vector<double> transfer_cells(const CellSource& from, const TetsInRegions& to,
                                   std::span<const BackgroundPlace> places, CellReconstruction shape,
                                   const TaskRunner& runner);

/// The means alone, for which `to` may be any tets of the mesh, each on its own.
std::vector<double> average_cells(const CellSource& from, const TetsInRegions& to,
                                  std::span<const BackgroundPlace> places, CellReconstruction shape,
                                  const TaskRunner& runner);

/// What is known of one component in one region.
struct RegionIntegrals {
  double volume = 0, integral = 0;
  double least = HUGE_VAL, greatest = -HUGE_VAL;

  double mean() const { return volume > 0 ? integral / volume : 0; }
  void add(const RegionIntegrals& other) {
    volume += other.volume, integral += other.integral;
    least = std::min(least, other.least), greatest = std::max(greatest, other.greatest);
  }
};

/// Of some tets, by region of `from`, ascending, and component. Those of all tets are what is put right by: where tets
/// lie in several places, the sums of these, in an order that is always the same.
std::vector<RegionIntegrals> sum_cells(const CellSource& from, const TetsInRegions& to, std::span<const double> values,
                                       const TaskRunner& runner);

/// Puts the values of some tets right, once per region: `after` are the sums over all tets, `before` those of `from`.
void put_right_cells(const CellSource& from, std::span<const RegionIntegrals> before,
                     std::span<const RegionIntegrals> after, std::span<const std::uint32_t> regions,
                     std::span<double> values, const TaskRunner& runner);

}  // namespace tetloom::adapt
