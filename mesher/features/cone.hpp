#pragma once
// The corner of a triangle as a plane cone of directions, and how near two of them come: whether two triangles at a
// common vertex lie one upon the other.
#include <array>

#include "tetloom/vec.hpp"

namespace tetloom::features {

/// All directions between two unit vectors, in their plane. Angles in radians.
struct Cone {
  Vec3 first, last;        ///< unit vectors along the sides
  Vec3 middle;             ///< unit vector half way between them
  Vec3 normal;             ///< of the triangle, unit length; zero where it has no area
  double half_cosine = 1;  ///< of half the angle between the sides, which is above 0 and below pi
};

/// The corner of the triangle `corner` b c at its first point.
Cone make_cone(const Vec3& corner, const Vec3& b, const Vec3& c);

/// The angle between a unit vector and the nearest direction of the cone.
double angle_to_cone(const Vec3& direction, const Cone& cone);

/// How nearly two cones lie upon each other: the angle between the middle of one and the nearest direction of the
/// other, in units of `limit`; where the middle lies beside the other cone and not over it, in units of .45 of the
/// angle of its own cone if that is smaller. The lesser of both ways. Below 1 where the cones lie upon each other at
/// less than `limit`. Cones side by side in a plane have 1.1 and more, however narrow they are. Infinite where one of
/// them has no angle.
double separation(const Cone& s, const Cone& t, double limit);

}  // namespace tetloom::features
