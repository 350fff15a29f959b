#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "adapt/parts/rounds.hpp"
#include "core/base/hilbert.hpp"

namespace tetloom::adapt {

namespace {

constexpr std::size_t kGrain = std::size_t{1} << 14;
constexpr std::size_t kSamples = std::size_t{1} << 14;
constexpr double kUnitsPerTet = 1024;
constexpr double kMostWork = 1e9;

// Tets whose numbers follow each other, of which the first one stands for all; ranks may have a piece each.
struct Sample {
  std::uint64_t number = 0;
  std::uint64_t key = std::numeric_limits<std::uint64_t>::max();  // where this rank does not have the first tet
  std::int64_t units = 0;
};

Box3 box_of(const WholeMesh& share, const SharedWork& work) {
  const std::size_t blocks = (share.size() + kGrain - 1) / kGrain;
  std::vector<Box3> boxes(blocks);
  work.runner().for_blocks(share.size(), kGrain, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin * 4; i < end * 4; ++i) boxes[begin / kGrain].add(share.points[share.to_vert[i]]);
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
    Vec3 sum;
    for (std::size_t i = 0; i < 4; ++i) sum += share_.points[share_.to_vert[tet * 4 + i]];
    const Vec3 x = scale_ * (0.25 * sum - lo_);
    const std::array<std::int64_t, 3> at{static_cast<std::int64_t>(x.x), static_cast<std::int64_t>(x.y),
                                         static_cast<std::int64_t>(x.z)};
    return hilbert_key(at[round_ % 3], at[(round_ + 1) % 3], at[(round_ + 2) % 3]);
  }

 private:
  const WholeMesh& share_;
  std::size_t round_;
  Vec3 lo_;
  double scale_ = 1;
};

std::int64_t work_units(float work) { return std::llround(std::min(double{work}, kMostWork) * kUnitsPerTet); }

// Samples of the whole mesh, in the order of its tets.
std::vector<Sample> gather_samples(const Curve& curve, const ShareLinks& links, std::span<const float> to_work,
                                   const SharedWork& work) {
  const std::size_t first = links.first_tets[static_cast<std::size_t>(work.rank())];
  const std::size_t step = std::max<std::size_t>(1, links.first_tets.back() / kSamples);
  const std::vector<Bytes> given = work.all_gather([&](MessageWriter& writer) {
    std::vector<Sample> own;
    for (std::size_t tet = 0; tet < to_work.size(); ++tet) {
      const std::size_t number = (first + tet) / step;
      if (own.empty() || own.back().number != number) own.push_back({.number = number});
      if ((first + tet) % step == 0) own.back().key = curve.key_of(tet);
      own.back().units += work_units(to_work[tet]);
    }
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

double sum_of_work(std::span<const float> to_work, const SharedWork& work) {
  std::array<std::int64_t, 1> sum{};
  for (const float one : to_work) sum[0] += work_units(one);
  work.sum(sum);
  return static_cast<double>(sum[0]) / kUnitsPerTet;
}

Dealing deal_tets(const WholeMesh& share, const ShareLinks& links, std::span<const float> to_work,
                  std::size_t part_count, std::size_t round, const SharedWork& work) {
  Dealing dealing;
  dealing.to_part.resize(share.size());
  dealing.work.resize(part_count);
  if (part_count > 1) {
    const Curve curve(share, box_of(share, work), round);
    const std::vector<std::uint64_t> cuts = find_cuts(gather_samples(curve, links, to_work, work), part_count);
    work.runner().for_blocks(share.size(), kGrain, [&](std::size_t begin, std::size_t end) {
      for (std::size_t tet = begin; tet < end; ++tet)
        dealing.to_part[tet] =
            static_cast<std::uint32_t>(std::upper_bound(cuts.begin(), cuts.end(), curve.key_of(tet)) - cuts.begin());
    });
  }
  for (std::size_t tet = 0; tet < share.size(); ++tet) dealing.work[dealing.to_part[tet]] += work_units(to_work[tet]);
  work.sum(dealing.work);
  return dealing;
}

}  // namespace tetloom::adapt
