#pragma once
// Lattices: the sizes they come in and where their points lie.
//
// A lattice of size h has cubes in which its mean edge is .99 h, and that of a whole mesh, with what lies at the
// surface, h. There is one lattice per size, in steps of about the cube root of 4 (Labelle & Shewchuk 2007 grade
// body-centred lattices by octrees in steps of 2, too coarse to keep edges near the size asked).
#include <cmath>
#include <cstdint>

#include "mesher/lattice/lattice_shape.hpp"
#include "tetloom/vec.hpp"

namespace tetloom::lattice {

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

/// One lattice, shifted off the axes of symmetry by shares of a cube that differ between levels. Each point is moved by
/// up to 1e-4 h, by a hash of its site: exact lattices are full of coplanar points, which are slow to insert.
class SiteLattice {
 public:
  /// `is_alone`: there are no other levels. Pre: size > 0 and finite.
  SiteLattice(LatticeKind kind, const Vec3& origin, double size, int level, bool is_alone);

  Vec3 point(const Site& site) const { return place(site) + shift(site); }
  /// Where the point would be if it was not moved, and how far it is moved along an axis at most.
  Vec3 place(const Site& site) const { return origin_ + part_ * Vec3{double(site.i), double(site.j), double(site.k)}; }
  double most_moved() const { return kJitter * size_; }
  double size() const { return size_; }
  LatticeKind kind() const { return kind_; }
  const LatticeShape& shape() const { return *shape_; }

  /// The least parts of cubes of which none lies below `x`: seldom a site.
  Site first_site(const Vec3& x) const {
    const Vec3 y = x - origin_;
    const auto first = [&](double value) { return static_cast<std::int32_t>(std::ceil(value / part_)); };
    return {first(y.x), first(y.y), first(y.z)};
  }
  /// Calls visit(site) for the sites in [first, end), by k, then j, then i. Between the first sites of two corners of a
  /// box lie the sites whose unmoved points lie in the half-open box.
  template <class Visit>
  void for_each_between(const Site& first, const Site& end, Visit&& visit) const {
    const LatticeShape::Row* rows = shape_->rows();
    const std::int32_t parts = shape_->parts(), mask = parts - 1;
    for (std::int32_t k = first.k; k < end.k; ++k) {
      for (std::int32_t j = first.j; j < end.j; ++j) {
        const LatticeShape::Row row = rows[(k & mask) * parts + (j & mask)];
        if (row.step == 0) continue;
        for (std::int32_t i = first.i + ((row.first - first.i) & (row.step - 1)); i < end.i; i += row.step)
          visit(Site{i, j, k});
      }
    }
  }

 private:
  static constexpr double kJitter = 1e-4;

  Vec3 shift(const Site& site) const;

  LatticeKind kind_;
  const LatticeShape* shape_;
  Vec3 origin_;
  double size_, part_;  // part_: of a cube, that sites are counted in
  std::uint64_t level_;
};

}  // namespace tetloom::lattice
