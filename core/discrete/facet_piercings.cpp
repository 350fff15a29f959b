#include "core/discrete/facet_piercings.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/base/lists.hpp"
#include "core/predicates/predicates.hpp"
#include "core/spatial/along_axis.hpp"
#include "core/spatial/bvh.hpp"

namespace tetloom::detail {
namespace {

enum class Meeting : std::uint8_t { None, Pierces, Touches };

// Of a segment and a triangle that lie in one plane: whether they have a point in common. By separating lines: along
// the segment, and along each side of the triangle.
bool meet_in_plane(const std::array<Vec3, 3>& triangle, const Vec3& from, const Vec3& to) {
  const int axis = nearest_axis(cross(triangle[1] - triangle[0], triangle[2] - triangle[0]));
  std::array<Vec2, 3> t;
  for (std::size_t i = 0; i < 3; ++i) t[i] = without_axis(triangle[i], axis);
  const Vec2 a = without_axis(from, axis), b = without_axis(to, axis);
  const std::array<int, 3> beside{orient2d(a, b, t[0]), orient2d(a, b, t[1]), orient2d(a, b, t[2])};
  if (beside[0] == beside[1] && beside[1] == beside[2] && beside[0] != 0) return false;
  const int turn = orient2d(t[0], t[1], t[2]);
  for (std::size_t i = 0; i < 3; ++i) {
    const Vec2 &p = t[i], &q = t[(i + 1) % 3];
    if (turn * orient2d(p, q, a) < 0 && turn * orient2d(p, q, b) < 0) return false;
  }
  return true;
}

Meeting meeting_of(const std::array<Vec3, 3>& t, const Vec3& from, const Vec3& to) {
  const int side_from = orient3d(t[0], t[1], t[2], from), side_to = orient3d(t[0], t[1], t[2], to);
  if (side_from * side_to > 0) return Meeting::None;
  if (side_from == 0 && side_to == 0) return meet_in_plane(t, from, to) ? Meeting::Touches : Meeting::None;
  bool is_beside = false, is_on_side = false;
  const int outside = side_from != 0 ? side_from : -side_to;  // how a side turns that the segment passes outside of
  for (std::size_t i = 0; i < 3; ++i) {
    const int turn = orient3d(from, to, t[i], t[(i + 1) % 3]);
    is_on_side = is_on_side || turn == 0;
    is_beside = is_beside || turn == outside;
  }
  if (is_beside) return Meeting::None;
  return is_on_side || side_from == 0 || side_to == 0 ? Meeting::Touches : Meeting::Pierces;
}

// Where the segment crosses the triangle's plane.
double share_at(const std::array<Vec3, 3>& t, const Vec3& from, const Vec3& to) {
  const Vec3 normal = cross(t[1] - t[0], t[2] - t[0]);
  const double above = dot(normal, from - t[0]), below = dot(normal, to - t[0]);
  return std::clamp(above / (above - below), 0.0, 1.0);
}

class PiercingSearch {
 public:
  PiercingSearch(std::span<const Vec3> points, std::span<const Triangle> tris, const FacetEdges& edges)
      : points_(points), tris_(tris), edges_(edges) {
    std::vector<Box3> boxes(tris.size());
    for (std::size_t t = 0; t < tris.size(); ++t)
      for (const std::uint32_t v : tris[t]) boxes[t].add(points[v]);
    bvh_ = build_bvh(boxes, serial_loop());
  }

  FacetPiercings run(const CancelToken* cancel) {
    constexpr std::uint32_t kEdgesBetweenLooks = 1 << 12;
    for (std::uint32_t edge = 0; edge < edges_.size(); ++edge) {
      if (edge % kEdgesBetweenLooks == 0) check_cancelled(cancel);
      look_along(edge);
    }
    sort_unique(found_.in_the_way);
    return std::move(found_);
  }

 private:
  void look_along(std::uint32_t edge) {
    const auto [a, b] = edges_.edge_to_vert[edge];
    const Vec3 &from = points_[a], &to = points_[b];
    Box3 box;
    box.add(from), box.add(to);
    const std::size_t first = found_.all.size();
    for_each_near(bvh_, box, [&](std::uint32_t tri) {
      const auto& [u, v, w] = tris_[tri];
      if (a == u || a == v || a == w || b == u || b == v || b == w) return;
      const std::array<Vec3, 3> corners{points_[u], points_[v], points_[w]};
      const Meeting meeting = meeting_of(corners, from, to);
      if (meeting == Meeting::Touches) found_.in_the_way.insert(found_.in_the_way.end(), {a, b});
      if (meeting != Meeting::Pierces) return;
      const double share = share_at(corners, from, to);
      found_.all.push_back({edge, tri, from + share * (to - from), share});
    });
    std::ranges::sort(found_.all.begin() + static_cast<std::ptrdiff_t>(first), found_.all.end(), {},
                      &FacetPiercing::tri);
  }

  std::span<const Vec3> points_;
  std::span<const Triangle> tris_;
  const FacetEdges& edges_;
  Bvh bvh_;
  FacetPiercings found_;
};

}  // namespace

FacetPiercings find_piercings(std::span<const Vec3> points, std::span<const Triangle> tris, const FacetEdges& edges,
                              const CancelToken* cancel) {
  return PiercingSearch(points, tris, edges).run(cancel);
}

}  // namespace tetloom::detail
