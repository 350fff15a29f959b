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

/// The corners of a face, in the order of kFaceVerts.
std::array<Vec3, 3> corners_of_face(const TetView& mesh, FaceCode face);

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
