#pragma once
// Space seen along a coordinate axis: exact, so what is apart in the plane is apart in space.
#include <cmath>

#include "tetloom/vec.hpp"

namespace tetloom {

/// The other two coordinates, in cyclic order: what turns left does so where the normal's coordinate is positive.
inline Vec2 without_axis(const Vec3& p, int axis) { return {p[(axis + 1) % 3], p[(axis + 2) % 3]}; }

/// The axis that is nearest to a direction, the first of several.
inline int nearest_axis(const Vec3& direction) {
  int axis = 0;
  for (const int other : {1, 2})
    if (std::abs(direction[other]) > std::abs(direction[axis])) axis = other;
  return axis;
}

}  // namespace tetloom
