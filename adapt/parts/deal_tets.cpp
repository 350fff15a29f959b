#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>

#include "adapt/parts/rounds.hpp"
#include "core/base/grain.hpp"
#include "core/spatial/hilbert.hpp"

namespace tetloom::adapt {

namespace {

constexpr std::size_t kMostSamples = std::size_t{1} << 14, kSamplesPerPart = std::size_t{1} << 9;
constexpr std::size_t kSampleGrain = std::size_t{1} << 8;
constexpr double kUnitsPerTet = 1024;
constexpr double kMostWork = 1e9;

// Tets whose numbers follow each other, of which the first one stands for all; ranks may have a piece each.
struct Sample {
  std::uint64_t number = 0;
  std::uint64_t key = std::numeric_limits<std::uint64_t>::max();  // where this rank does not have the first tet
  std::int64_t units = 0;
};

// Along a curve through a box that is larger than the mesh and lies otherwise in each round.
class Curve {
 public:
  Curve(const WholeMesh& share, const Box3& box, std::size_t round) : share_(share), round_(round) {
    const Vec3 extent = box.hi - box.lo;
    const double width = std::max({extent.x, extent.y, extent.z, 1e-300});
    // Fractions of the golden ratio keep away from each other.
    const double shift = 0.5 * static_cast<double>(round_ * 618034 % 1000000) * 1e-6;
    lo_ = box.lo - Vec3{shift * width, shift * width * 0.7, (0.5 - shift) * width};
    scale_ = ((1 << kHilbertBits) - 1) / (1.6 * width);
  }

  std::uint64_t key_of(std::size_t tet) const {
    const Cell at = cell_of(tet);
    return hilbert_key(at[0], at[1], at[2]);
  }
  // The part that has the tet, where the curve is cut.
  std::uint32_t part_of(std::size_t tet, std::span<const std::uint64_t> cuts) const {
    if (cuts.empty()) return 0;
    const Cell at = cell_of(tet);
    return static_cast<std::uint32_t>(hilbert_piece(at[0], at[1], at[2], cuts));
  }

 private:
  using Cell = std::array<std::int64_t, 3>;

  Cell cell_of(std::size_t tet) const {
    Vec3 sum;
    for (std::size_t i = 0; i < 4; ++i) sum += share_.points[share_.to_vert[tet * 4 + i]];
    const Vec3 x = scale_ * (0.25 * sum - lo_);
    const Cell at{static_cast<std::int64_t>(x.x), static_cast<std::int64_t>(x.y), static_cast<std::int64_t>(x.z)};
    return {at[round_ % 3], at[(round_ + 1) % 3], at[(round_ + 2) % 3]};
  }

  const WholeMesh& share_;
  std::size_t round_;
  Vec3 lo_;
  double scale_ = 1;
};

std::int64_t work_units(float work) {
  return static_cast<std::int64_t>(std::min(double{work}, kMostWork) * kUnitsPerTet + 0.5);
}

std::int64_t sum_of_units(std::span<const float> to_work) {
  std::int64_t sum = 0;
  for (const float one : to_work) sum += work_units(one);
  return sum;
}

// Samples of the whole mesh, in the order of its tets.
std::vector<Sample> gather_samples(const Curve& curve, const ShareLinks& links, std::span<const float> to_work,
                                   std::size_t part_count, const SharedWork& work) {
  const std::size_t first = links.first_tets[static_cast<std::size_t>(work.rank())] - links.first_tets.front();
  const std::size_t step =
      std::max<std::size_t>(1, links.tet_count() / std::min(kMostSamples, kSamplesPerPart * part_count));
  const std::size_t last = first + to_work.size(), lowest = first / step;
  const std::vector<Bytes> given = work.all_gather([&](MessageWriter& writer) {
    std::vector<Sample> own(last > first ? (last - 1) / step + 1 - lowest : 0);
    work.runner().for_blocks(own.size(), kSampleGrain, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) {
        Sample& sample = own[i];
        sample.number = lowest + i;
        const std::size_t from = std::max(first, sample.number * step), to = std::min(last, (sample.number + 1) * step);
        if (from == sample.number * step) sample.key = curve.key_of(from - first);
        sample.units = sum_of_units(to_work.subspan(from - first, to - from));
      }
    });
    writer.put_array(std::span<const Sample>(own));
  });
  std::vector<Sample> samples;
  for (const Bytes& bytes : given) {
    MessageReader reader(bytes);
    for (const Sample& sample : reader.get_view<Sample>()) {
      if (samples.empty() || samples.back().number != sample.number) {
        samples.push_back(sample);
      } else {
        samples.back().key = std::min(samples.back().key, sample.key);
        samples.back().units += sample.units;
      }
    }
  }
  return samples;
}

std::vector<std::uint64_t> find_cuts(std::vector<Sample> samples, std::size_t part_count) {
  std::ranges::sort(samples, {}, &Sample::key);
  std::int64_t all = 0, sum = 0;
  for (const Sample& sample : samples) all += sample.units;
  std::vector<std::uint64_t> cuts;
  for (const Sample& sample : samples) {
    sum += sample.units;
    while (cuts.size() + 1 < part_count && static_cast<double>(sum) >= static_cast<double>(all) *
                                                                           static_cast<double>(cuts.size() + 1) /
                                                                           static_cast<double>(part_count))
      cuts.push_back(sample.key);
  }
  return cuts;
}

}  // namespace

Box3 box_of(const WholeMesh& share, const SharedWork& work) {
  // All of its points are in use.
  const auto boxes = map_blocks(work.runner(), share.points.size(), kElementGrain, Box3(),
                                [&](std::size_t begin, std::size_t end, Box3& result) {
                                  Box3 box;
                                  for (std::size_t v = begin; v < end; ++v) box.add(share.points[v]);
                                  result = box;
                                });
  std::array<double, 6> ends;
  ends.fill(-std::numeric_limits<double>::infinity());
  for (const Box3& box : boxes) {
    const std::array<double, 6> own{box.hi.x, box.hi.y, box.hi.z, -box.lo.x, -box.lo.y, -box.lo.z};
    for (std::size_t i = 0; i < 6; ++i) ends[i] = std::max(ends[i], own[i]);
  }
  work.max(ends);
  Box3 box;
  box.add(Vec3{ends[0], ends[1], ends[2]}), box.add(Vec3{-ends[3], -ends[4], -ends[5]});
  return box;
}

double sum_of_work(std::span<const float> to_work, const SharedWork& work) {
  const auto sums = map_blocks(work.runner(), to_work.size(), kElementGrain, std::int64_t{0},
                               [&](std::size_t begin, std::size_t end, std::int64_t& sum) {
                                 sum = sum_of_units(to_work.subspan(begin, end - begin));
                               });
  std::array<std::int64_t, 1> sum{std::accumulate(sums.begin(), sums.end(), std::int64_t{0})};
  work.sum(sum);
  return static_cast<double>(sum[0]) / kUnitsPerTet;
}

Dealing deal_tets(const WholeMesh& share, const ShareLinks& links, std::span<const float> to_work,
                  std::size_t part_count, std::size_t round, const SharedWork& work) {
  Dealing dealing;
  dealing.to_part.resize_for_overwrite(share.size());
  const Curve curve(share, box_of(share, work), round);
  std::vector<std::uint64_t> cuts;
  if (part_count > 1) cuts = find_cuts(gather_samples(curve, links, to_work, part_count, work), part_count);
  const std::size_t grain = grain_of_tables(share.size(), kElementGrain);
  const auto sums = map_blocks(work.runner(), share.size(), grain, std::vector<std::int64_t>(),
                               [&](std::size_t begin, std::size_t end, std::vector<std::int64_t>& units) {
                                 units.resize(part_count);
                                 for (std::size_t tet = begin; tet < end; ++tet) {
                                   const std::uint32_t part = curve.part_of(tet, cuts);
                                   dealing.to_part[tet] = part;
                                   units[part] += work_units(to_work[tet]);
                                 }
                               });
  dealing.work.resize(part_count);
  for (const std::vector<std::int64_t>& units : sums)
    for (std::size_t part = 0; part < part_count; ++part) dealing.work[part] += units[part];
  work.sum(dealing.work);
  return dealing;
}

}  // namespace tetloom::adapt
