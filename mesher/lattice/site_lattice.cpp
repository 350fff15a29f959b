#include "mesher/lattice/site_lattice.hpp"

#include <algorithm>

#include "core/base/mix_bits.hpp"

namespace tetloom::lattice {

namespace {

constexpr double kStep = 1.5874010519681994;  // the cube root of 4

}  // namespace

Levels::Levels(double lo, double hi) : smallest_(lo) {
  const int steps = static_cast<int>(std::lround(std::log(hi / lo) / std::log(kStep)));
  if (steps == 0) {
    smallest_ = std::sqrt(lo) * std::sqrt(hi);
    return;
  }
  log_ratio_ = std::log(hi / lo) / steps;
  ratio_ = std::exp(log_ratio_);
  half_step_ = std::sqrt(ratio_);
  count_ = steps + 1;
}

int Levels::of(double size) const {
  if (count_ == 1) return 0;
  const double level = std::log(size / smallest_) / log_ratio_;
  return std::clamp(static_cast<int>(std::lround(level)), 0, count_ - 1);
}

SiteLattice::SiteLattice(LatticeKind kind, const Vec3& origin, double size, int level, bool is_alone)
    : kind_(kind), shape_(&LatticeShape::of(kind)), size_(size), level_(static_cast<std::uint64_t>(level)) {
  const double cube = (is_alone ? shape_->cube_per_size() : shape_->graded_cube_per_size()) * size;
  part_ = cube / shape_->parts();
  const double turn = level * 0.7548776662466927;
  const auto share = [&](double x) { return cube * (x + turn - std::floor(x + turn)); };
  origin_ = origin - Vec3{share(0.3819660113), share(0.2360679775), share(0.1458980338)};
}

Vec3 SiteLattice::shift(const Site& site) const {
  std::uint64_t hash = level_;
  for (const std::int32_t index : {site.i, site.j, site.k})
    hash = mix_bits(hash * 0x9e3779b97f4a7c15u + static_cast<std::uint64_t>(static_cast<std::int64_t>(index)));
  const auto part = [&](int bits) { return kJitter * size_ * (double(hash >> bits & 0x1fffff) / 0x100000 - 1); };
  return {part(0), part(21), part(42)};
}

}  // namespace tetloom::lattice
