#include "core/base/filing.hpp"

namespace tetloom {

std::vector<FilingWindow> cut_filing_windows(std::span<const std::size_t> counts, std::size_t limit) {
  std::vector<FilingWindow> windows;
  FilingWindow open;
  for (std::size_t key = 0; key < counts.size(); ++key) {
    if (open.uses > 0 && open.uses + counts[key] > limit) {
      windows.push_back(open);
      open = {key, key, 0};
    }
    open.last = key + 1;
    open.uses += counts[key];
  }
  if (open.uses > 0) windows.push_back(open);
  return windows;
}

std::vector<std::size_t> FilingPlan::totals() const {
  std::vector<std::size_t> totals(ranges_, 0);
  for (std::size_t i = 0; i < places_.size(); ++i) totals[i % ranges_] += places_[i];
  return totals;
}

std::vector<std::size_t> FilingPlan::lay_out(const FilingWindow& window) {
  std::vector<std::size_t> ends;
  std::size_t end = 0;
  for (std::size_t range = window.first; range < window.last; ++range) {
    for (std::size_t place = range; place < places_.size(); place += ranges_) {
      const std::size_t uses = places_[place];
      places_[place] = end;
      end += uses;
    }
    ends.push_back(end);
  }
  return ends;
}

}  // namespace tetloom
