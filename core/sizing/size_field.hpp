#pragma once
// The target edge length at every point of space.
#include "core/base/vec.hpp"

namespace tetloom {

// (octree representation: to be written in this folder)
class SizeField {
 public:
  /// The same size everywhere. Pre: size > 0.
  static SizeField uniform(double size);

  /// Target edge length at `x` (model length), > 0; defined in the whole space. Wait-free, allocates nothing, may be
  /// called by any number of threads.
  double size_at(const Vec3& x) const;
  /// The smallest and largest size that the field holds.
  double smallest() const { return smallest_; }
  double largest() const { return largest_; }

 private:
  double smallest_ = 0, largest_ = 0;
};

}  // namespace tetloom
