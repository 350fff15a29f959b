#pragma once
// A plane on which layers stand, exact where it is normal to an axis.
#include <cmath>
#include <memory>

#include "tetloom/model.hpp"
#include "tetloom/vec.hpp"

namespace tetloom::layers {

/// The plane of a flat side face, with a frame.
struct SidePlane {
  Vec3 origin, first, second, normal;  ///< an orthonormal frame, right-handed

  /// Pre: `normal` is of length 1. One that is an axis but for rounding becomes it.
  static SidePlane through(const Vec3& origin, Vec3 normal) {
    constexpr double kRounding = 1e-9;
    for (int axis = 0; axis < 3; ++axis)
      if (1 - std::abs(normal[axis]) < kRounding) {
        const double sign = normal[axis] > 0 ? 1 : -1;
        normal = {};
        normal[axis] = sign;
      }
    const Vec3 other = std::abs(normal.x) < 0.6 ? Vec3{1, 0, 0} : Vec3{0, 1, 0};
    const Vec3 second = normalized(cross(normal, other));
    return {origin, cross(second, normal), second, normal};
  }

  double height(const Vec3& x) const { return dot(x - origin, normal); }
  Vec2 to_plane(const Vec3& x) const { return {dot(x - origin, first), dot(x - origin, second)}; }

  /// The nearest point; on planes normal to an axis, to the last bit.
  Vec3 project(const Vec3& x) const {
    Vec3 result = x - height(x) * normal;
    for (int axis = 0; axis < 3; ++axis)
      if (std::abs(normal[axis]) == 1) result[axis] = origin[axis];
    return result;
  }
};

/// The plane as a face, with lengths in the plane for (u,v) and without edges of its own.
std::unique_ptr<FaceGeometry> make_geometry(const SidePlane& plane);

}  // namespace tetloom::layers
