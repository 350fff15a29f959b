#pragma once
// The direction in which a growth curve leaves a surface.
#include <array>
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

/// The ways within a front around a point: two where the front is smooth, that along the edge where it has one, none at
/// a corner; shortened where it turns little.
struct FrontFreedom {
  std::array<Vec3, 2> ways;  ///< normal to each other, of length 0 to 1

  /// The part of `way` that lies within the front.
  Vec3 within(const Vec3& way) const { return dot(way, ways[0]) * ways[0] + dot(way, ways[1]) * ways[1]; }
};

/// Of a front of these normals, of length 1: by the eigenvectors of what they vary by (Jiao 2007, face offsetting).
FrontFreedom find_freedom(std::span<const Vec3> normals);

}  // namespace tetloom::layers
