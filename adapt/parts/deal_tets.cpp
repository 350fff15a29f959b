#include <algorithm>

#include "adapt/parts/whole_mesh.hpp"
#include "core/base/hilbert.hpp"

namespace tetloom::adapt {

namespace {

constexpr std::size_t kGrain = std::size_t{1} << 14;
constexpr std::size_t kSamples = std::size_t{1} << 14;

struct Sample {
  std::uint64_t key;
  double work;
  friend bool operator<(const Sample& a, const Sample& b) { return a.key < b.key; }
};

// Along a curve through a box that is larger than the mesh and lies otherwise in each round.
class Curve {
 public:
  Curve(const WholeMesh& whole, std::size_t round) : whole_(whole), round_(round) {
    Box3 box;
    for (const Vec3& x : whole.points) box.add(x);
    const Vec3 extent = box.hi - box.lo;
    const double width = std::max({extent.x, extent.y, extent.z, 1e-300});
    // Fractions of the golden ratio keep away from each other.
    const double shift = 0.5 * static_cast<double>(round_ * 618034 % 1000000) * 1e-6;
    lo_ = box.lo - Vec3{shift * width, shift * width * 0.7, (0.5 - shift) * width};
    scale_ = ((1 << kHilbertBits) - 1) / (1.6 * width);
  }

  std::uint64_t key_of(std::size_t tet) const {
    Vec3 sum;
    for (std::size_t i = 0; i < 4; ++i) sum += whole_.points[whole_.to_vert[tet * 4 + i]];
    const Vec3 x = scale_ * (0.25 * sum - lo_);
    const std::array<std::int64_t, 3> at{static_cast<std::int64_t>(x.x), static_cast<std::int64_t>(x.y),
                                         static_cast<std::int64_t>(x.z)};
    return hilbert_key(at[round_ % 3], at[(round_ + 1) % 3], at[(round_ + 2) % 3]);
  }

 private:
  const WholeMesh& whole_;
  std::size_t round_;
  Vec3 lo_;
  double scale_ = 1;
};

}  // namespace

std::vector<std::uint32_t> deal_tets(const WholeMesh& whole, std::span<const float> to_work, std::size_t part_count,
                                     std::size_t round, const TaskRunner& runner) {
  std::vector<std::uint32_t> to_part(whole.size(), 0);
  if (part_count < 2) return to_part;
  const Curve curve(whole, round);
  const std::size_t step = std::max<std::size_t>(1, whole.size() / kSamples);
  std::vector<Sample> samples;
  double all = 0;
  for (std::size_t tet = 0; tet < whole.size(); tet += step) {
    double work = 0;
    for (std::size_t i = tet; i < std::min(whole.size(), tet + step); ++i) work += double{to_work[i]};
    samples.push_back({curve.key_of(tet), work});
    all += work;
  }
  std::sort(samples.begin(), samples.end());
  std::vector<std::uint64_t> cuts;
  double sum = 0;
  for (const Sample& sample : samples) {
    sum += sample.work;
    while (cuts.size() + 1 < part_count &&
           sum >= all * static_cast<double>(cuts.size() + 1) / static_cast<double>(part_count))
      cuts.push_back(sample.key);
  }
  runner.for_blocks(whole.size(), kGrain, [&](std::size_t begin, std::size_t end) {
    for (std::size_t tet = begin; tet < end; ++tet)
      to_part[tet] =
          static_cast<std::uint32_t>(std::upper_bound(cuts.begin(), cuts.end(), curve.key_of(tet)) - cuts.begin());
  });
  return to_part;
}

}  // namespace tetloom::adapt
