#include "core/base/lists.hpp"
#include "core/mesh/statistics_detail.hpp"

#include <array>

#include "core/mesh/quantile.hpp"

namespace tetloom {
namespace {

constexpr std::size_t kBins = 4096;
using BinCounts = std::array<std::uint32_t, kBins>;

// Never falls where the value rises.
std::size_t bin_of(float value) {
  return value >= 1 ? kBins - 1 : value > 0 ? static_cast<std::size_t>(value * static_cast<float>(kBins)) : 0;
}

std::size_t grain_for(std::size_t count) { return std::max(std::size_t{1} << 16, count / 256 + 1); }

}  // namespace

std::vector<std::int64_t> count_bins(std::span<const float> values, const BlockLoop& loop) {
  const auto of_blocks = map_blocks(loop, values.size(), grain_for(values.size()), BinCounts{},
                                    [&](std::size_t begin, std::size_t end, BinCounts& counts) {
                                      for (std::size_t i = begin; i < end; ++i) ++counts[bin_of(values[i])];
                                    });
  std::vector<std::int64_t> totals(kBins, 0);
  for (const BinCounts& counts : of_blocks)
    for (std::size_t bin = 0; bin < kBins; ++bin) totals[bin] += counts[bin];
  return totals;
}

QuantileBins find_bins(std::span<const std::int64_t> counts, double share) {
  std::size_t all = 0;
  for (const std::int64_t count : counts) all += static_cast<std::size_t>(count);
  QuantileBins bins;
  if (all == 0) return bins;
  bins.position = share * static_cast<double>(all - 1);
  bins.below = static_cast<std::size_t>(bins.position);
  bins.above = std::min(bins.below + 1, all - 1);
  const auto count_of = [&](std::size_t bin) { return static_cast<std::size_t>(counts[bin]); };
  while (bins.before + count_of(bins.first) <= bins.below) bins.before += count_of(bins.first++);
  bins.last = bins.first;
  for (std::size_t end = bins.before + count_of(bins.first); end <= bins.above; end += count_of(++bins.last)) continue;
  return bins;
}

std::vector<float> values_in(std::span<const float> values, const QuantileBins& bins, const BlockLoop& loop) {
  const auto of_blocks = map_blocks(loop, values.size(), grain_for(values.size()), std::vector<float>(),
                                    [&](std::size_t begin, std::size_t end, std::vector<float>& found) {
                                      for (std::size_t i = begin; i < end; ++i) {
                                        const std::size_t bin = bin_of(values[i]);
                                        if (bin >= bins.first && bin <= bins.last) found.push_back(values[i]);
                                      }
                                    });
  return joined(of_blocks);
}

double quantile_of(std::vector<float>&& near, const QuantileBins& bins) {
  if (near.empty()) return 0;
  const auto middle = near.begin() + static_cast<std::ptrdiff_t>(bins.below - bins.before);
  std::nth_element(near.begin(), middle, near.end());
  if (bins.above == bins.below) return *middle;
  const double upper = *std::min_element(middle + 1, near.end());
  return *middle + (bins.position - static_cast<double>(bins.below)) * (upper - *middle);
}

double detail::quantile(std::span<const float> values, double share, const BlockLoop& loop) {
  if (values.empty()) return 0;
  const QuantileBins bins = find_bins(count_bins(values, loop), share);
  return quantile_of(values_in(values, bins, loop), bins);
}

}  // namespace tetloom
