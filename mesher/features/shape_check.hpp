#pragma once
// Whether a local change of a surface leaves it a surface that volumes can be filled from.
#include "mesher/features/local_change.hpp"

namespace tetloom::features {

/// The least height of a triangle: twice its area over its longest edge.
double least_height(const Vec3& a, const Vec3& b, const Vec3& c);

/// The corners of a triangle of the surface, and those of an added one after the change.
std::array<Vec3, 3> corners(const SurfaceComplex& surface, std::uint32_t triangle);
std::array<Vec3, 3> corners(const SurfaceComplex& surface, const LocalChange& change, const Triangle& verts);

/// The least height or quality before and after.
struct BeforeAfter {
  double before = HUGE_VAL, after = HUGE_VAL;
};
BeforeAfter compare_heights(const SurfaceComplex& surface, const LocalChange& change);
BeforeAfter compare_shapes(const SurfaceComplex& surface, const LocalChange& change);

/// Whether no triangle that was wider than half of `tolerance` turns by more than about 80 degrees, and no triangle
/// comes to lie upon another one at a common vertex: at an angle below .3 degrees where no region lies between the two;
/// where one does, at twice the angle that the feature has as it is, the length that is merged over the longest edge
/// beside it, though never below 1 degree and at most at 15. Angles that were there already may stay, and lose up to a
/// third. This is local: surfaces that meet from afar are found by the test for self-intersections.
bool keeps_shape(const SurfaceComplex& surface, const LocalChange& change, double tolerance);

}  // namespace tetloom::features
