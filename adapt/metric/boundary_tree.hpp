#pragma once
// The triangles that bound a mesh of tetrahedra, and which of them is nearest to a point.
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "adapt/metric/tet_links.hpp"
#include "core/spatial/bvh.hpp"
#include "tetloom/metric.hpp"
#include "tetloom/tasks.hpp"

namespace tetloom::adapt {

/// The point of a triangle that is nearest to some other point, by its barycentric coordinates.
struct TrianglePoint {
  std::array<double, 3> weights{};  ///< not negative, sum 1
  double distance2 = HUGE_VAL;      ///< squared
};

/// After Ericson, "Real-time collision detection" (2005), 5.1.5.
TrianglePoint closest_on_triangle(const Vec3& x, const Vec3& a, const Vec3& b, const Vec3& c);

/// The corners of a face, in the order of kFaceVerts.
std::array<Vec3, 3> corners_of_face(const TetView& mesh, FaceCode face);

/// How far boxes may be away, squared, that are to be looked into where something at a squared distance of `distance2`
/// from x is known: a little more than that, so that what is found as near does not depend on the order of looking,
/// whatever was rounded.
double reach_of_boxes(double distance2, const Vec3& x);

/// Immutable, and thread-safe therefore.
class BoundaryTree {
 public:
  BoundaryTree() = default;
  BoundaryTree(const TetView& mesh, std::vector<FaceCode> faces, const TaskRunner& runner);

  struct Nearest {
    FaceCode face;  ///< not valid: nothing within the limit
    TrianglePoint point;
  };
  /// The face nearest to x that is nearer than sqrt(limit2); the lowest of equals. `mesh` is that of the constructor.
  Nearest find_nearest(const TetView& mesh, const Vec3& x, double limit2) const;

 private:
  std::vector<FaceCode> faces_;  ///< in the order of the hierarchy
  Bvh bvh_;
};

}  // namespace tetloom::adapt
