#pragma once
// The direction in which a growth curve leaves a surface.
#include <span>

#include "tetloom/vec.hpp"

namespace tetloom::layers {

/// A direction and how well the triangles see it.
struct GrowthDirection {
  Vec3 direction;         ///< of length 1; zero where there is none
  double visibility = 0;  ///< its least dot product with the normals
};

/// The direction whose least dot product with the `normals`, of length 1, is greatest: the axis of the smallest cone
/// around them (Aubry & Löhner 2008: most normal direction). The result depends on the order by rounding alone.
GrowthDirection most_normal_direction(std::span<const Vec3> normals);

/// The least dot product of `direction` with the normals.
double visibility_of(const Vec3& direction, std::span<const Vec3> normals);

}  // namespace tetloom::layers
