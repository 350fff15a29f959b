#include "core/mesh/statistics_detail.hpp"

#include <array>

namespace tetloom::detail {
namespace {

constexpr std::size_t kBins = 4096;
using BinCounts = std::array<std::uint32_t, kBins>;

// Never falls where the value rises.
std::size_t bin_of(float value) {
  return value >= 1 ? kBins - 1 : value > 0 ? static_cast<std::size_t>(value * static_cast<float>(kBins)) : 0;
}

std::size_t grain_for(std::size_t count) { return std::max(std::size_t{1} << 16, count / 256 + 1); }

std::array<std::size_t, kBins> count_bins(std::span<const float> values, const BlockLoop& loop) {
  const auto of_blocks = map_blocks(loop, values.size(), grain_for(values.size()), BinCounts{},
                                    [&](std::size_t begin, std::size_t end, BinCounts& counts) {
                                      for (std::size_t i = begin; i < end; ++i) ++counts[bin_of(values[i])];
                                    });
  std::array<std::size_t, kBins> totals{};
  for (const BinCounts& counts : of_blocks)
    for (std::size_t bin = 0; bin < kBins; ++bin) totals[bin] += counts[bin];
  return totals;
}

std::vector<float> values_in(std::span<const float> values, std::size_t first_bin, std::size_t last_bin,
                             const BlockLoop& loop) {
  const auto of_blocks = map_blocks(loop, values.size(), grain_for(values.size()), std::vector<float>(),
                                    [&](std::size_t begin, std::size_t end, std::vector<float>& found) {
                                      for (std::size_t i = begin; i < end; ++i) {
                                        const std::size_t bin = bin_of(values[i]);
                                        if (bin >= first_bin && bin <= last_bin) found.push_back(values[i]);
                                      }
                                    });
  std::vector<float> all;
  for (const std::vector<float>& found : of_blocks) all.insert(all.end(), found.begin(), found.end());
  return all;
}

}  // namespace

double quantile(std::span<const float> values, double share, const BlockLoop& loop) {
  if (values.empty()) return 0;
  const double position = share * static_cast<double>(values.size() - 1);
  const auto below = static_cast<std::size_t>(position);
  const std::size_t above = std::min(below + 1, values.size() - 1);
  const std::array<std::size_t, kBins> counts = count_bins(values, loop);
  std::size_t first_bin = 0, before = 0;  // values in lower bins
  while (before + counts[first_bin] <= below) before += counts[first_bin++];
  std::size_t last_bin = first_bin;
  for (std::size_t end = before + counts[first_bin]; end <= above; end += counts[++last_bin]) continue;
  std::vector<float> near = values_in(values, first_bin, last_bin, loop);
  const auto middle = near.begin() + static_cast<std::ptrdiff_t>(below - before);
  std::nth_element(near.begin(), middle, near.end());
  if (above == below) return *middle;
  const double upper = *std::min_element(middle + 1, near.end());
  return *middle + (position - static_cast<double>(below)) * (upper - *middle);
}

}  // namespace tetloom::detail
