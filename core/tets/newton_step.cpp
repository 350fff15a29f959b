#include "core/tets/newton_step.hpp"

#include <algorithm>

#include "core/tets/tet_pairs.hpp"

namespace tetloom::tets {

namespace {

using pairs::Pair;
using pairs::PairVec;
using pairs::TetPair;

constexpr int kHalvings = 3;    // of a step that goes too far
constexpr double kReach = 1.2;  // over-relaxation: neighbours follow, so that fewer passes do

// Up to the factor 432: the sum of 1/q^3, and the largest of 1/q^3.
struct Badness {
  double sum = 0, worst = 0;
};

// w (s / 6 - 1)^2, which is least where the squared edges of a tet have 1 as their mean, up to the same factor.
class SizeTerm {
 public:
  explicit SizeTerm(double weight) : weight_(pairs::pair_of(432 * weight)) {}

  // Those of no tets count nothing.
  Pair at(Pair squares) const {
    const Pair t = squares * kPerSquare - 1;
    return squares > Pair{} ? weight_ * t * t : Pair{};
  }
  // Derivatives by s.
  Pair first(Pair squares) const {
    return squares > Pair{} ? 2 * kPerSquare * weight_ * (squares * kPerSquare - 1) : Pair{};
  }
  Pair second(Pair squares) const { return squares > Pair{} ? 2 * kPerSquare * kPerSquare * weight_ : Pair{}; }

 private:
  static constexpr double kPerSquare = 1.0 / 6;
  Pair weight_;
};

// Sums 1/q^3 of pairs of tets.
struct BadnessSums {
  Pair sum{}, worst{};

  void add(Pair term) {
    sum += term;
    worst = pairs::max(worst, term);
  }
  Badness badness() const { return {pairs::sum(sum), std::max(worst[0], worst[1])}; }
};

// False when a tet is not surely positive at `d`.
bool badness_at(std::span<const StarTet> star, const Vec3& d, const SizeTerm* size, Badness& badness) {
  const PairVec pair_d = pairs::pair_of(d);
  const Pair squares_of_d = pairs::pair_of(3 * norm2(d));
  BadnessSums sums;
  Pair least_volume = pairs::pair_of(1), least_margin = pairs::pair_of(1);
  pairs::for_each_pair(star, [&](const TetPair& tet) {
    const Pair v = tet.volume + dot(tet.normal, pair_d), s = tet.squares - 2 * dot(tet.middle, pair_d) + squares_of_d;
    const Pair v2 = v * v, largest = pairs::max(s, tet.squares);
    least_volume = pairs::min(least_volume, v);
    least_margin = pairs::min(least_margin, 432 * v2 - kSurelyPositive * largest * largest * largest);
    sums.add(s * s * s / v2);
    if (size) sums.sum += size->at(s);
  });
  badness = sums.badness();
  return least_volume[0] > 0 && least_volume[1] > 0 && least_margin[0] > 0 && least_margin[1] > 0;
}

// Gradient and Hessian of the sum of f = s^3 / v^2, where ds = -2 middle, d2s = 6 and dv = normal.
class Quadratic {
 public:
  explicit Quadratic(const SizeTerm* size) : size_(size) {}

  void add(const TetPair& tet) {
    const Pair i = 1 / tet.volume, r = tet.squares * i, r2 = r * r, r3 = r2 * r;
    const PairVec &m = tet.middle, &n = tet.normal;
    sums_.add(tet.squares * r2);
    gradient_ = gradient_ + (-6 * r2) * m + (-2 * r3) * n;
    const Pair mn = 12 * r2 * i, nn = 6 * r3 * i;
    Pair identity = 18 * r2, mm = 24 * r * i;
    if (size_) {
      sums_.sum += size_->at(tet.squares);
      const Pair first = size_->first(tet.squares);
      gradient_ = gradient_ + (-2 * first) * m;
      // Where lengths are below 1 the term is concave; what it takes must not outweigh the shape.
      identity += pairs::max(6 * first, -12 * r2);
      mm += 4 * size_->second(tet.squares);
    }
    const PairVec a = mm * m + mn * n, b = mn * m + nn * n;
    xx_ += identity + a.x * m.x + b.x * n.x;
    yy_ += identity + a.y * m.y + b.y * n.y;
    zz_ += identity + a.z * m.z + b.z * n.z;
    xy_ += a.x * m.y + b.x * n.y;
    xz_ += a.x * m.z + b.x * n.z;
    yz_ += a.y * m.z + b.y * n.z;
  }

  Badness badness() const { return sums_.badness(); }

  // -H^-1 g; not finite when H is singular.
  Vec3 step() const {
    using pairs::sum;
    const double xy = sum(xy_), xz = sum(xz_), yz = sum(yz_);
    const Vec3 c0{sum(xx_), xy, xz}, c1{xy, sum(yy_), yz}, c2{xz, yz, sum(zz_)};
    const Vec3 r{-sum(gradient_.x), -sum(gradient_.y), -sum(gradient_.z)};
    const Vec3 n = cross(c1, c2);
    return Vec3{dot(r, n), dot(c0, cross(r, c2)), dot(c0, cross(c1, r))} / dot(c0, n);
  }

 private:
  PairVec gradient_{};
  Pair xx_{}, yy_{}, zz_{}, xy_{}, xz_{}, yz_{};
  BadnessSums sums_;
  const SizeTerm* size_;
};

}  // namespace

double size_badness(std::span<const StarTet> star, const Vec3& d, double size_weight) {
  double sum = 0;
  for (const StarTet& tet : star) {
    const double t = tet.squares_at(d) / 6 - 1;
    sum += t * t;
  }
  return size_weight * sum;
}

Vec3 find_newton_step(std::span<const StarTet> star, const Vec3& x, double floor, double size_weight) {
  const SizeTerm term(size_weight);
  const SizeTerm* size = size_weight > 0 ? &term : nullptr;
  Quadratic quadratic(size);
  pairs::for_each_pair(star, [&](const TetPair& tet) { quadratic.add(tet); });
  const Badness before = quadratic.badness();
  const double bearable = std::max(before.worst, 432 / floor);
  Vec3 step = kReach * quadratic.step();
  if (!is_finite(step)) return {};
  for (int i = 0; i <= kHalvings; ++i, step *= 0.5) {
    const Vec3 d = (x + step) - x;
    Badness after;
    if (badness_at(star, d, size, after) && after.sum < before.sum && after.worst <= bearable) return d;
  }
  return {};
}

}  // namespace tetloom::tets
