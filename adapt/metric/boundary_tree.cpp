#include "adapt/metric/boundary_tree.hpp"

#include "core/spatial/distances.hpp"
#include "tetloom/tasks.hpp"

namespace tetloom::adapt {

std::array<Vec3, 3> corners_of_face(const TetView& mesh, FaceCode face) {
  const TetVerts& tet = mesh.tets[face.tet()];
  const auto& f = kFaceVerts[face.side()];
  return {mesh.points[tet[f[0]]], mesh.points[tet[f[1]]], mesh.points[tet[f[2]]]};
}

BoundaryTree::BoundaryTree(const TetView& mesh, std::vector<FaceCode> faces, const TaskRunner& runner) {
  std::vector<Box3> boxes(faces.size());
  runner.for_blocks(faces.size(), 1 << 12, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i)
      for (const Vec3& corner : corners_of_face(mesh, faces[i])) boxes[i].add(corner);
  });
  bvh_ = build_bvh(boxes, runner);
  faces_.reserve(faces.size());
  for (const std::uint32_t item : bvh_.order) faces_.push_back(faces[item]);
  bvh_.order = {};
}

BoundaryTree::Nearest BoundaryTree::find_nearest(const TetView& mesh, const Vec3& x, double limit2) const {
  Nearest nearest;
  nearest.point.distance2 = limit2;
  double reach2 = reach_of_boxes(limit2, x);
  visit_nearest_first(
      bvh_, x, [&] { return reach2; },
      [&](std::uint32_t i) {
        const std::array<Vec3, 3> c = corners_of_face(mesh, faces_[i]);
        const TrianglePoint point = closest_on_triangle(x, c[0], c[1], c[2]);
        const bool nearer = point.distance2 < nearest.point.distance2;
        const bool equal = point.distance2 == nearest.point.distance2 && nearest.face.valid();
        if (nearer || (equal && faces_[i] < nearest.face)) nearest = {faces_[i], point};
        if (nearer) reach2 = reach_of_boxes(point.distance2, x);
      });
  return nearest;
}

}  // namespace tetloom::adapt
