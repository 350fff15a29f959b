#include "threading/balance/bisection_detail.hpp"

namespace tetloom::balance_detail {

namespace {

/// A cut may be off by this share of its set, so that rounds of the search are saved.
constexpr int kToleranceBits = 12;

/// Cuts below `key` of the current component, with `below` on the left.
void settle(Search& search, std::uint64_t key, std::int64_t below) {
  search.at[search.component] = key;
  search.below = below;
  search.done = true;
}

/// The bin holds one value of the component, and still more than may be on the wrong side: on to the next component.
void descend(Search& search, std::uint64_t value, std::int64_t below, std::uint64_t highest) {
  search.at[search.component] = value;
  search.below = below;
  ++search.component;
  search.low = 0;
  search.high = highest;
}

}  // namespace

int bin_shift(std::uint64_t low, std::uint64_t high, std::uint64_t bins) {
  int shift = 0;
  while ((high - low) >> shift >= bins) ++shift;
  return shift;
}

std::uint64_t bins_for(std::size_t sets) {
  return std::clamp<std::uint64_t>(std::bit_floor((std::size_t{1} << 18) / sets), 8, 2048);
}

void narrow(ItemSet& set, std::span<const std::int64_t> histogram, std::span<const std::uint64_t> highest) {
  Search& search = set.search;
  const std::int64_t wanted = set.left_share(set.weight);
  std::int64_t before = search.below + histogram[0];
  if (before > wanted) {
    search.high = search.low - 1;
    search.low = 0;
    return;
  }
  if (before == wanted) return settle(search, search.low, before);
  const std::size_t bins = histogram.size() - 2;
  for (std::size_t bin = 0; bin < bins; ++bin) {
    const std::int64_t inside = histogram[bin + 1], after = before + inside;
    if (after < wanted) {
      before = after;
      continue;
    }
    const std::uint64_t low = search.low + (std::uint64_t{bin} << search.shift);
    const std::uint64_t width = std::uint64_t{1} << search.shift;
    const bool last = search.component + 1 == highest.size();
    if (inside <= set.weight >> kToleranceBits || (search.shift == 0 && last))
      return wanted - before <= after - wanted ? settle(search, low, before) : settle(search, low + width, after);
    if (search.shift == 0) return descend(search, low, before, highest[search.component + 1]);
    search.low = low;
    search.high = low + width - 1;
    return;
  }
  search.low += std::uint64_t{bins} << search.shift;
  search.high = highest[search.component];
}

std::array<ItemSet, 2> halves(const ItemSet& set) {
  const std::uint32_t left = set.left_count();
  return {ItemSet{set.first, left, set.search.below, {}},
          ItemSet{set.first + left, set.count - left, set.weight - set.search.below, {}}};
}

}  // namespace tetloom::balance_detail
