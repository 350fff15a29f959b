#pragma once
// Body-centred cubic lattices: the sizes they come in and where their points lie.
//
// The Delaunay tetrahedra of such a lattice are all alike, of mean ratio .945; a lattice of size h has cubes 1.07 h
// wide: its mean edge is .99 h, and that of a whole mesh, with what lies at the surface, h. There is one lattice per
// size, in steps of about the cube root of 4 (Labelle & Shewchuk 2007 grade by octrees in steps of 2, too coarse to
// keep edges near the size asked).
#include <array>
#include <cmath>
#include <cstdint>

#include "core/base/vec.hpp"

namespace tetloom::lattice {

/// Widths of cubes, in sizes: with one size, and with several, where edges between lattices are shorter.
inline constexpr double kCubePerSize = 1.07, kGradedCubePerSize = 1.083;

/// Sizes smallest · ratio^k for 0 <= k < count.
class Levels {
 public:
  /// Covers [lo, hi]; one level when they are nearly the same. Pre: 0 < lo <= hi, finite.
  Levels(double lo, double hi);
  int count() const { return count_; }
  double size(int level) const { return smallest_ * std::pow(ratio_, level); }
  /// The level nearest to `size` in the logarithm.
  int of(double size) const;
  /// The sizes of a level, but for those halfway to another one: at least `lo`, below `hi`.
  struct Range {
    double lo, hi;
    bool holds(double size) const { return size >= lo && size < hi; }
  };
  Range range(int level) const {
    return {level == 0 ? 0 : size(level) / half_step_, level + 1 == count_ ? HUGE_VAL : size(level + 1) / half_step_};
  }

 private:
  double half_step_ = 1;  // square root of the ratio
  double smallest_, log_ratio_ = 0, ratio_ = 1;
  int count_ = 1;
};

/// A point of a lattice: its coordinates in half cubes, all even (a corner) or all odd (a centre).
struct Site {
  std::int32_t i, j, k;
  friend constexpr auto operator<=>(const Site&, const Site&) = default;
};

/// One lattice, shifted off the axes of symmetry by shares of a cube that differ between levels. Each point is moved by
/// up to 1e-4 h, by a hash of its site: exact lattices are full of coplanar points, which are slow to insert.
class BccLattice {
 public:
  /// Pre: size > 0 and finite, cube_per_size below 1.1 (cell_sites.hpp counts on it).
  BccLattice(const Vec3& origin, double size, double cube_per_size, int level);

  Vec3 point(const Site& site) const {
    return origin_ + half_ * Vec3{double(site.i), double(site.j), double(site.k)} + shift(site);
  }
  double size() const { return size_; }

  /// The least half-cube coordinates of which none lies below `x`; not a site unless they are of one parity.
  Site first_site(const Vec3& x) const {
    const Vec3 y = x - origin_;
    const auto first = [&](double value) { return static_cast<std::int32_t>(std::ceil(value / half_)); };
    return {first(y.x), first(y.y), first(y.z)};
  }
  /// Calls visit(site) for the sites in [first, end), by k, then j, then i. Between the first sites of two corners of a
  /// box lie the sites whose unmoved points lie in the half-open box.
  template <class Visit>
  void for_each_between(const Site& first, const Site& end, Visit&& visit) const {
    for (std::int32_t k = first.k; k < end.k; ++k) {
      for (std::int32_t j = first.j + ((first.j + k) & 1); j < end.j; j += 2) {
        for (std::int32_t i = first.i + ((first.i + k) & 1); i < end.i; i += 2) visit(Site{i, j, k});
      }
    }
  }

 private:
  Vec3 shift(const Site& site) const;

  Vec3 origin_;
  double size_, half_;
  std::uint64_t level_;
};

}  // namespace tetloom::lattice
