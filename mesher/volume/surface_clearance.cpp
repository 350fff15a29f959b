#include "mesher/volume/surface_clearance.hpp"

#include <algorithm>

#include "mesher/intersection/triangle_pair.hpp"

namespace tetloom::volume {

namespace {

using tets::SurfaceChange;
using tets::TriangleVerts;

Box3 box_of(std::span<const Vec3> points, const TriangleVerts& triangle) {
  Box3 box;
  for (const std::uint32_t v : triangle) box.add(points[v]);
  return box;
}

bool share_vertex(const TriangleVerts& a, const TriangleVerts& b) {
  return std::ranges::any_of(a, [&](std::uint32_t v) { return std::ranges::find(b, v) != b.end(); });
}

bool is_degenerate(std::span<const Vec3> points, const TriangleVerts& t) {
  return intersection::is_degenerate(points[t[0]], points[t[1]], points[t[2]]);
}

}  // namespace

bool SurfaceClearance::meets(const SurfaceChange& change, std::uint32_t other) const {
  if (std::ranges::find(change.triangles, other) != change.triangles.end()) return false;
  const TriangleVerts& verts = triangles_[other];
  const Box3 box = box_of(change.points, verts);
  for (std::size_t i = 0; i < change.triangles.size(); ++i) {
    const TriangleVerts& own = change.verts[i];
    if (!box.overlaps(own_boxes_[i])) continue;
    if (tri_to_face_[other] == tri_to_face_[change.triangles[i]] && share_vertex(own, verts)) continue;
    if (is_degenerate(change.points, own)) return true;
    if (!is_degenerate(change.points, verts) && intersection::check_pair(change.points, own, verts)) return true;
  }
  return false;
}

bool SurfaceClearance::is_clear(const SurfaceChange& change) {
  const bool open = std::ranges::any_of(change.triangles, [&](std::uint32_t t) {
    return !complex_.tri_to_sides[t].front.valid() || !complex_.tri_to_sides[t].back.valid();
  });
  if (open) {
    Box3 box;
    own_boxes_.clear();
    for (const TriangleVerts& verts : change.verts) box.add(own_boxes_.emplace_back(box_of(change.points, verts)));
    const Vec3 margin{farthest_, farthest_, farthest_};
    box = {box.lo - margin, box.hi + margin};
    bool met = false;
    tree_.for_each_leaf_in(box, 0, [&](std::size_t leaf) {
      for (const std::uint32_t other : tree_.leaf_triangles(leaf)) met = met || meets(change, other);
    });
    const auto meets_swapped = [&](const Swapped& other) {
      return other.box.overlaps(box) && meets(change, other.triangle);
    };
    if (met || std::ranges::any_of(swapped_, meets_swapped)) return false;
  }
  note(change);
  return true;
}

void SurfaceClearance::note(const SurfaceChange& change) {
  for (std::size_t i = 0; i < change.triangles.size(); ++i) {
    const std::uint32_t triangle = change.triangles[i];
    for (const std::uint32_t v : change.verts[i])
      farthest_ = std::max(farthest_, distance(change.points[v], complex_.points[v]));
    if (change.verts[i] != triangles_[triangle])
      swapped_.push_back({box_of(complex_.points, change.verts[i]), triangle});
  }
}

}  // namespace tetloom::volume
