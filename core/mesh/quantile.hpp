#pragma once
// A quantile of values that may lie in several places: bins are counted there, and what is in the bins around the
// quantile is brought together. Quick where the values spread over [0, 1].
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "tetloom/host.hpp"

namespace tetloom {

/// Where a quantile lies among all values, ascending.
struct QuantileBins {
  std::size_t first = 0, last = 0;   ///< bins that have its neighbours
  std::size_t before = 0;            ///< values in lower bins
  std::size_t below = 0, above = 0;  ///< places of its neighbours
  double position = 0;               ///< between them
};

/// How many values fall into each bin; to be added up over all places.
std::vector<std::int64_t> count_bins(std::span<const float> values, const BlockLoop& loop);
/// Of the `share` quantile, of counts from all places.
QuantileBins find_bins(std::span<const std::int64_t> counts, double share);
/// Those of one place that the quantile is made of.
std::vector<float> values_in(std::span<const float> values, const QuantileBins& bins, const BlockLoop& loop);
/// The quantile, interpolated linearly between its neighbours, of those of all places in any order; 0 of none.
double quantile_of(std::vector<float>&& near, const QuantileBins& bins);

}  // namespace tetloom
