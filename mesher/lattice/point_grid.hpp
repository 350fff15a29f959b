#pragma once
// Points sorted into the cubes of a grid, to ask whether one lies near a place.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <span>
#include <vector>

#include "tetloom/vec.hpp"

namespace tetloom::lattice {

/// Add points, finish, then ask: queries may come from any number of threads.
class PointGrid {
 public:
  /// Pre: radius > 0.
  explicit PointGrid(double radius) : radius_(radius) {}

  void add(std::span<const Vec3> points) {
    for (const Vec3& x : points) entries_.push_back({cube_of(x), x});
  }
  void finish() {
    std::sort(entries_.begin(), entries_.end(), [](const Entry& a, const Entry& b) { return a.cube < b.cube; });
  }
  /// True when an added point lies nearer to `x` than the radius. Pre: finished.
  bool any_within(const Vec3& x) const {
    const Cube center = cube_of(x);
    for (std::int64_t dz = -1; dz <= 1; ++dz) {
      for (std::int64_t dy = -1; dy <= 1; ++dy) {
        if (any_in_row({center[0] + dz, center[1] + dy, center[2]}, x)) return true;
      }
    }
    return false;
  }

 private:
  using Cube = std::array<std::int64_t, 3>;  // z, y, x
  struct Entry {
    Cube cube;
    Vec3 point;
  };

  Cube cube_of(const Vec3& x) const {
    const auto index = [&](double value) { return static_cast<std::int64_t>(std::floor(value / radius_)); };
    return {index(x.z), index(x.y), index(x.x)};
  }
  // The cubes middle - 1 … middle + 1 along x.
  bool any_in_row(const Cube& middle, const Vec3& x) const {
    const Cube first{middle[0], middle[1], middle[2] - 1}, last{middle[0], middle[1], middle[2] + 1};
    auto entry = std::lower_bound(entries_.begin(), entries_.end(), first,
                                  [](const Entry& a, const Cube& cube) { return a.cube < cube; });
    for (; entry != entries_.end() && entry->cube <= last; ++entry) {
      if (norm2(entry->point - x) < radius_ * radius_) return true;
    }
    return false;
  }

  double radius_;
  std::vector<Entry> entries_;
};

}  // namespace tetloom::lattice
