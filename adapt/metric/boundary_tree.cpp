#include "adapt/metric/boundary_tree.hpp"

#include <algorithm>
#include <cmath>

#include "core/spatial/distances.hpp"
#include "tetloom/tasks.hpp"

namespace tetloom::adapt {
namespace {

constexpr double kRounded = 1e-12;  // of coordinates and distances

TrianglePoint at(const Vec3& x, const Vec3& a, const Vec3& b, const Vec3& c, const std::array<double, 3>& weights) {
  return {weights, norm2(x - (weights[0] * a + weights[1] * b + weights[2] * c))};
}

/// How far along from `a` to `b` the nearest point lies, from 0 to 1.
double along(double to_a, double to_b) { return to_a <= 0 ? 0 : to_b <= 0 ? 1 : to_a / (to_a + to_b); }

}  // namespace

std::array<Vec3, 3> corners_of_face(const TetView& mesh, FaceCode face) {
  const TetVerts& tet = mesh.tets[face.tet()];
  const auto& f = kFaceVerts[face.side()];
  return {mesh.points[tet[f[0]]], mesh.points[tet[f[1]]], mesh.points[tet[f[2]]]};
}

double reach_of_boxes(double distance2, const Vec3& x) {
  const double distance = std::sqrt(distance2);
  const double reach = distance + kRounded * (distance + std::max({std::abs(x.x), std::abs(x.y), std::abs(x.z)}));
  return reach * reach;
}

TrianglePoint closest_on_triangle(const Vec3& x, const Vec3& a, const Vec3& b, const Vec3& c) {
  const Vec3 ab = b - a, ac = c - a, normal = cross(ab, ac);
  const double area2 = norm2(normal);
  const Vec3 ax = x - a, bx = x - b, cx = x - c;
  if (area2 > 0) {
    const double wc = dot(cross(ab, ax), normal), wa = dot(cross(c - b, bx), normal);
    const double wb = area2 - wc - wa;
    if (wa >= 0 && wb >= 0 && wc >= 0) return at(x, a, b, c, {wa / area2, wb / area2, wc / area2});
  }
  // The nearest of three edges: simple, and safe for triangles without area.
  const double tab = along(dot(ax, ab), -dot(bx, ab)), tac = along(dot(ax, ac), -dot(cx, ac));
  const double tbc = along(dot(bx, c - b), -dot(cx, c - b));
  TrianglePoint best = at(x, a, b, c, {1 - tab, tab, 0});
  for (const auto& weights : {std::array<double, 3>{1 - tac, 0, tac}, std::array<double, 3>{0, 1 - tbc, tbc}}) {
    const TrianglePoint other = at(x, a, b, c, weights);
    if (other.distance2 < best.distance2) best = other;
  }
  return best;
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
  if (bvh_.nodes.empty()) return nearest;
  double reach2 = reach_of_boxes(limit2, x);
  std::array<std::uint32_t, 64> stack;  // as deep as a balanced tree of 2^32 leaves needs, twice over
  std::size_t size = 0;
  stack[size++] = 0;
  while (size > 0) {
    const std::uint32_t index = stack[--size];
    const BvhNode& node = bvh_.nodes[index];
    if (squared_distance_to_box(x, node.box) > reach2) continue;
    if (node.right == 0) {
      for (std::uint32_t i = node.begin; i < node.end; ++i) {
        const std::array<Vec3, 3> c = corners_of_face(mesh, faces_[i]);
        const TrianglePoint point = closest_on_triangle(x, c[0], c[1], c[2]);
        const bool nearer = point.distance2 < nearest.point.distance2;
        const bool equal = point.distance2 == nearest.point.distance2 && nearest.face.valid();
        if (nearer || (equal && faces_[i] < nearest.face)) nearest = {faces_[i], point};
        if (nearer) reach2 = reach_of_boxes(point.distance2, x);
      }
      continue;
    }
    const std::uint32_t left = index + 1, right = node.right;
    const bool left_first =
        squared_distance_to_box(x, bvh_.nodes[left].box) <= squared_distance_to_box(x, bvh_.nodes[right].box);
    stack[size++] = left_first ? right : left;
    stack[size++] = left_first ? left : right;
  }
  return nearest;
}

}  // namespace tetloom::adapt
