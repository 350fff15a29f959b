#include "threading/balance/cut_planes_detail.hpp"

#include <bit>
#include <cmath>
#include <limits>

namespace tetloom::balance_detail {

namespace {

using Interval = std::array<std::uint64_t, 2>;

constexpr std::array<Normal, 13> kNormals{{{1, 0, 0},
                                           {0, 1, 0},
                                           {0, 0, 1},
                                           {1, 1, 0},
                                           {1, -1, 0},
                                           {1, 0, 1},
                                           {1, 0, -1},
                                           {0, 1, 1},
                                           {0, 1, -1},
                                           {1, 1, 1},
                                           {1, 1, -1},
                                           {1, -1, 1},
                                           {-1, 1, 1}}};
constexpr std::size_t kBins = 256;
/// The density is taken over this many bins on each side of the cut: more than the planes of a lattice lie apart.
constexpr std::size_t kReach = 8;
/// Found by trial on three jittered Kuhn lattices, as was the square root below: smoothing evens out part of what
/// planes cut in excess, and oblique planes leave pieces that are worse to cut further.
constexpr double kObliqueHandicap = 1.15;
constexpr std::size_t kMaxSets = 512;
constexpr std::size_t kMaxSetsOblique = 64;

std::uint64_t hash(const Point3f& p) {
  std::uint64_t h = std::bit_cast<std::uint32_t>(p.x + 0.0F);  // + 0: both zeros are one place
  for (const float v : {p.y, p.z}) h = (h ^ (h >> 29)) * 0xbf58476d1ce4e5b9U + std::bit_cast<std::uint32_t>(v + 0.0F);
  h = (h ^ (h >> 30)) * 0x94d049bb133111ebU;
  return h ^ (h >> 31);
}

int sample_shift(std::int64_t count) {
  if (count <= std::int64_t{1} << 16) return 0;
  int shift = 2;
  while (count >> shift > std::int64_t{1} << 20) ++shift;
  return shift;
}

double length(const Normal& n) { return std::sqrt(static_cast<double>(n[0] * n[0] + n[1] * n[1] + n[2] * n[2])); }

/// The bin in which the share of the weight that `set` wants on its left is reached; kBins where all are empty.
std::size_t find_cut_bin(const ItemSet& set, std::span<const std::int64_t> bins) {
  std::int64_t total = 0;
  for (const std::int64_t w : bins) total += w;
  if (total == 0) return kBins;
  const std::int64_t wanted = set.left_share(total);
  std::size_t bin = 0;
  for (std::int64_t before = bins[0]; before < wanted; before += bins[++bin]) {}
  return bin;
}

double density_around(std::span<const std::int64_t> bins, std::size_t cut) {
  const std::size_t begin = cut < kReach ? 0 : cut - kReach, end = std::min(kBins, cut + kReach + 1);
  std::int64_t weight = 0;
  for (std::size_t bin = begin; bin < end; ++bin) weight += bins[bin];
  return static_cast<double>(weight);
}

}  // namespace

PlaneChooser::PlaneChooser(const Items& items, TargetRange range, CutPlanes planes)
    : items_(items), range_(range), normals_(kNormals), set_of_(range.count, kNoSet) {
  if (planes == CutPlanes::Axes) normals_ = normals_.first(3);
  const std::uint64_t low = height(kNormals[0], {});
  const Interval whole{low, low + (std::uint64_t{1} << Frame::kPlaceBits) - 1};
  boxes_.assign(range.count, {whole, whole, whole});
  if (range.count > 1) draw(items);
}

void PlaneChooser::draw(const Items& items) {
  samples_.resize(items.lanes(0));
  const std::uint64_t mask = (std::uint64_t{1} << sample_shift(items.count())) - 1;
  measure_costs(items, mask);
  items.for_chunks(samples_.size(), [&](std::size_t lane, const Chunk& chunk) {
    const ItemBlock& block = items.blocks()[chunk.block];
    for (std::size_t i = chunk.begin; i < chunk.end; ++i) {
      if (hash(block.points[i]) & mask) continue;
      const auto place = items.frame().place_of(block.points[i]);
      samples_[lane].push_back({{static_cast<std::int32_t>(place[0]), static_cast<std::int32_t>(place[1]),
                                 static_cast<std::int32_t>(place[2])},
                                static_cast<std::uint32_t>(items.frame().weight_of(block, i)),
                                range_.first});
    }
  });
}

void PlaneChooser::measure_costs(const Items& items, std::uint64_t mask) {
  const auto sums = items.sum_over_items(kNormals.size(), [&](std::span<std::int64_t> sum, const Chunk& chunk) {
    const ItemBlock& block = items.blocks()[chunk.block];
    for (std::size_t i = chunk.begin; !block.neighbours.empty() && i < chunk.end; ++i) {
      if (hash(block.points[i]) & mask) continue;
      const auto place = items.frame().place_of(block.points[i]);
      for (const std::uint32_t code : block.neighbours.subspan(4 * i, 4)) {
        if (code / 4 >= block.points.size()) continue;
        const auto other = items.frame().place_of(block.points[code / 4]);
        for (std::size_t d = 0; d < kNormals.size(); ++d)
          sum[d] += std::abs(static_cast<std::int64_t>(height(kNormals[d], place) - height(kNormals[d], other)));
      }
    }
  });
  // Where no neighbours are known all directions cost the same: a step along a normal is as long as the normal.
  costs_.resize(kNormals.size());
  for (std::size_t d = 0; d < kNormals.size(); ++d) {
    costs_[d] = length(kNormals[d]);
    if (sums[0] > 0) costs_[d] = std::sqrt(costs_[d] * static_cast<double>(sums[d]) / static_cast<double>(sums[0]));
    if (sums[0] > 0 && d >= 3) costs_[d] *= kObliqueHandicap;
  }
}

void PlaneChooser::number(std::span<const ItemSet> sets) {
  std::fill(set_of_.begin(), set_of_.end(), kNoSet);
  for (std::uint32_t s = 0; s < sets.size(); ++s) set_of_[sets[s].first - range_.first] = s;
}

std::vector<Normal> PlaneChooser::choose(std::span<ItemSet> sets) {
  std::vector<Normal> normals(sets.size());
  if (sets.size() > kMaxSetsOblique) normals_ = normals_.first(3);
  if (sets.size() > kMaxSets) {
    for (std::size_t s = 0; s < sets.size(); ++s)
      normals[s] = choose_by_box(sets[s], boxes_[sets[s].first - range_.first]);
    return normals;
  }
  number(sets);
  const auto ranges = find_ranges(sets);
  const auto bins = count_bins(sets, ranges);
  const std::size_t directions = normals_.size();
  for (std::size_t s = 0; s < sets.size(); ++s) {
    const auto own = std::span(ranges).subspan(s * directions, directions);
    Box& box = boxes_[sets[s].first - range_.first];
    const bool sampled = own[0][0] <= own[0][1];
    if (sampled) box = {own[0], own[1], own[2]};
    normals[s] =
        sampled ? choose_by_sample(sets[s], own, std::span(bins).subspan(s * directions * kBins, directions * kBins))
                : choose_by_box(sets[s], box);
  }
  return normals;
}

std::vector<std::array<std::uint64_t, 2>> PlaneChooser::find_ranges(std::span<const ItemSet> sets) const {
  const std::size_t directions = normals_.size(), size = sets.size() * directions;
  std::vector<std::vector<Interval>> found(samples_.size(), std::vector<Interval>(size, Interval{kHighestHeight, 0}));
  items_.runner().for_each(samples_.size(), [&](std::size_t lane) {
    for (const Sample& sample : samples_[lane]) {
      const std::uint32_t s = set_of_[sample.label - range_.first];
      if (s == kNoSet) continue;
      for (std::size_t d = 0; d < directions; ++d) {
        const std::uint64_t h = height(normals_[d], {sample.place[0], sample.place[1], sample.place[2]});
        Interval& interval = found[lane][s * directions + d];
        interval[0] = std::min(interval[0], h);
        interval[1] = std::max(interval[1], h);
      }
    }
  });
  std::vector<double> all(2 * size, -static_cast<double>(kHighestHeight));
  for (const auto& of_lane : found)
    for (std::size_t i = 0; i < size; ++i) {
      all[2 * i] = std::max(all[2 * i], -static_cast<double>(of_lane[i][0]));
      all[2 * i + 1] = std::max(all[2 * i + 1], static_cast<double>(of_lane[i][1]));
    }
  items_.communicator().max(all);
  std::vector<Interval> ranges(size);
  for (std::size_t i = 0; i < size; ++i)
    ranges[i] = {static_cast<std::uint64_t>(-all[2 * i]), static_cast<std::uint64_t>(all[2 * i + 1])};
  return ranges;
}

std::vector<std::int64_t> PlaneChooser::count_bins(std::span<const ItemSet> sets,
                                                   std::span<const Interval> ranges) const {
  const std::size_t directions = normals_.size();
  std::vector<int> shifts(ranges.size());
  for (std::size_t i = 0; i < ranges.size(); ++i)
    shifts[i] = ranges[i][0] <= ranges[i][1] ? bin_shift(ranges[i][0], ranges[i][1], kBins) : 0;
  std::vector<std::vector<std::int64_t>> sums(samples_.size());
  items_.runner().for_each(samples_.size(), [&](std::size_t lane) {
    sums[lane].assign(sets.size() * directions * kBins, 0);
    for (const Sample& sample : samples_[lane]) {
      const std::uint32_t s = set_of_[sample.label - range_.first];
      if (s == kNoSet) continue;
      for (std::size_t d = 0; d < directions; ++d) {
        const std::uint64_t h = height(normals_[d], {sample.place[0], sample.place[1], sample.place[2]});
        const std::size_t i = s * directions + d;
        sums[lane][i * kBins + ((h - ranges[i][0]) >> shifts[i])] += sample.weight;
      }
    }
  });
  for (std::size_t lane = 1; lane < sums.size(); ++lane)
    for (std::size_t i = 0; i < sums[0].size(); ++i) sums[0][i] += sums[lane][i];
  items_.communicator().sum(sums[0]);
  return std::move(sums[0]);
}

Normal PlaneChooser::choose_by_sample(ItemSet& set, std::span<const Interval> ranges,
                                      std::span<const std::int64_t> bins) const {
  double smallest = std::numeric_limits<double>::infinity();
  Normal best{};
  for (std::size_t d = 0; d < normals_.size(); ++d) {
    const auto own = bins.subspan(d * kBins, kBins);
    const std::size_t cut = find_cut_bin(set, own);
    const int shift = bin_shift(ranges[d][0], ranges[d][1], kBins);
    const double area = density_around(own, cut) * std::ldexp(costs_[d], -shift);
    if (area >= smallest) continue;
    smallest = area;
    best = normals_[d];
    const std::uint64_t width = std::uint64_t{1} << shift, low = ranges[d][0] + cut * width;
    set.search.low = low < width ? 0 : low - width;
    set.search.high = low + 2 * width - 1;
  }
  return best;
}

Normal PlaneChooser::choose_by_box(ItemSet& set, const Box& box) const {
  std::size_t longest = 0;
  for (std::size_t axis = 1; axis < 3; ++axis)
    if (box[axis][1] - box[axis][0] > box[longest][1] - box[longest][0]) longest = axis;
  set.search.low = box[longest][0];
  set.search.high = box[longest][1];
  return kNormals[longest];
}

void PlaneChooser::split(std::span<const ItemSet> sets, std::span<const Normal> normals) {
  number(sets);
  for (std::size_t s = 0; s < sets.size(); ++s) {
    const std::uint32_t left = sets[s].first - range_.first, right = left + sets[s].left_count();
    boxes_[right] = boxes_[left];
    const std::uint64_t at = sets[s].search.at[0];
    for (std::size_t axis = 0; axis < 3; ++axis)
      if (normals[s] == kNormals[axis]) {
        boxes_[left][axis][1] = std::clamp(at, boxes_[left][axis][0], boxes_[left][axis][1]);
        boxes_[right][axis][0] = std::clamp(at, boxes_[right][axis][0], boxes_[right][axis][1]);
      }
  }
  items_.runner().for_each(samples_.size(), [&](std::size_t lane) {
    for (Sample& sample : samples_[lane]) {
      const std::uint32_t s = set_of_[sample.label - range_.first];
      if (s == kNoSet) continue;
      const std::array<std::int64_t, 3> place{sample.place[0], sample.place[1], sample.place[2]};
      const Search& search = sets[s].search;
      const CutKey key{height(normals[s], place), static_cast<std::uint64_t>(place[0]),
                       static_cast<std::uint64_t>(place[1]), static_cast<std::uint64_t>(place[2])};
      const auto settled = search.component + 1;
      const bool right = !std::lexicographical_compare(key.begin(), key.begin() + settled, search.at.begin(),
                                                       search.at.begin() + settled);
      if (right) sample.label += sets[s].left_count();
    }
  });
}

}  // namespace tetloom::balance_detail
