#include "core/discrete/facet_bvh.hpp"

#include <algorithm>
#include <cmath>

#include "tetloom/host.hpp"

namespace tetloom::detail {
namespace {

bool ray_touches(const Vec3& origin, const Vec3& direction, const Box3& box) {
  double from = 0, to = HUGE_VAL;
  for (int axis = 0; axis < 3; ++axis) {
    if (direction[axis] == 0) {
      if (origin[axis] < box.lo[axis] || origin[axis] > box.hi[axis]) return false;
      continue;
    }
    const double a = (box.lo[axis] - origin[axis]) / direction[axis],
                 b = (box.hi[axis] - origin[axis]) / direction[axis];
    from = std::max(from, std::min(a, b)), to = std::min(to, std::max(a, b));
  }
  return from <= to * (1 + 1e-12) + 1e-300;
}

/// The frame along the longest edge of all.
OrthogonalFrame frame_along_longest_edge(std::span<const Vec3> points, std::span<const Triangle> tri_to_vert) {
  Vec3 longest;
  for (const Triangle& t : tri_to_vert)
    for (std::size_t i = 0; i < 3; ++i)
      if (const Vec3 edge = points[t[(i + 1) % 3]] - points[t[i]]; norm2(edge) > norm2(longest)) longest = edge;
  if (norm2(longest) == 0) return {};
  const Vec3 along = normalized(longest);
  const Vec3 across = normalized(cross(along, std::abs(along.x) < 0.5 ? Vec3{1, 0, 0} : Vec3{0, 1, 0}));
  return {{along, across, cross(along, across)}, false};
}

using Corners = std::array<Vec3, 3>;

Corners corners_in(const OrthogonalFrame& frame, std::span<const Vec3> points, const Triangle& t) {
  return {frame(points[t[0]]), frame(points[t[1]]), frame(points[t[2]])};
}

/// How often boxes are met: the sum of their surfaces (Goldsmith & Salmon, Automatic creation of object hierarchies,
/// 1987).
double surface_of_boxes(const OrthogonalFrame& frame, std::span<const Vec3> points,
                        std::span<const Triangle> tri_to_vert) {
  double sum = 0;
  for (const Triangle& t : tri_to_vert) {
    const Box3 box = box_of(corners_in(frame, points, t));
    const Vec3 size = box.hi - box.lo;
    sum += size.x * size.y + size.y * size.z + size.z * size.x;
  }
  return sum;
}

OrthogonalFrame choose_frame(std::span<const Vec3> points, std::span<const Triangle> tri_to_vert) {
  constexpr double kFarSmaller = 0.5;
  const OrthogonalFrame axes, along = frame_along_longest_edge(points, tri_to_vert);
  const bool is_worth_it =
      surface_of_boxes(along, points, tri_to_vert) < kFarSmaller * surface_of_boxes(axes, points, tri_to_vert);
  return is_worth_it ? along : axes;
}

int longest_axis(const Box3& box) {
  const Vec3 size = box.hi - box.lo;
  return size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2;
}

/// Into how many pieces a facet is cut.
std::size_t pieces_of(const Box3& box, double longest) {
  const int axis = longest_axis(box);
  return std::max<std::size_t>(1, static_cast<std::size_t>(std::ceil((box.hi[axis] - box.lo[axis]) / longest)));
}

/// How long a piece may be: some times the size of a facet, or what leaves not too many pieces.
double longest_piece(const OrthogonalFrame& frame, std::span<const Vec3> points,
                     std::span<const Triangle> tri_to_vert) {
  constexpr double kLong = 8, kGrowth = 1.5, kLeastShare = 1e-6;  // of a facet, and of the whole
  constexpr std::size_t kMostPerFacet = 4, kAlwaysAllowed = std::size_t{1} << 18;
  double twice_area = 0;
  std::vector<Box3> boxes;
  Box3 all;
  for (const Triangle& t : tri_to_vert) {
    const Corners corners = corners_in(frame, points, t);
    twice_area += norm(cross(corners[1] - corners[0], corners[2] - corners[0]));
    boxes.push_back(box_of(corners));
    all.add(boxes.back());
  }
  const double facet = std::sqrt(0.5 * twice_area / static_cast<double>(boxes.size()));
  double longest = std::max(kLong * facet, kLeastShare * all.diagonal());
  if (!(longest > 0)) return HUGE_VAL;
  const auto count = [&] {
    std::size_t pieces = 0;
    for (const Box3& box : boxes) pieces += pieces_of(box, longest);
    return pieces;
  };
  while (count() > std::max(kMostPerFacet * boxes.size(), kAlwaysAllowed)) longest *= kGrowth;
  return longest;
}

/// The box of what lies of a triangle between two planes across the longest axis of its box, at shares of that.
Box3 box_between(const Corners& corners, const Box3& box, double from, double to) {
  const int axis = longest_axis(box);
  const double length = box.hi[axis] - box.lo[axis];
  const std::array<double, 2> planes{box.lo[axis] + from * length, box.lo[axis] + to * length};
  Box3 part;
  for (std::size_t i = 0; i < 3; ++i) {
    const Vec3 &a = corners[i], &b = corners[(i + 1) % 3];
    if (a[axis] >= planes[0] && a[axis] <= planes[1]) part.add(a);
    for (const double plane : planes)
      if ((a[axis] < plane) != (b[axis] < plane)) part.add(a + (plane - a[axis]) / (b[axis] - a[axis]) * (b - a));
  }
  return part;
}

}  // namespace

FacetBvh::FacetBvh(std::span<const Vec3> points, std::span<const Triangle> tri_to_vert)
    : frame_(choose_frame(points, tri_to_vert)), points_(points), tri_to_vert_(tri_to_vert) {
  const Pieces pieces = cut_facets();
  bvh_ = build_bvh(pieces.boxes, serial_loop());
  facets_.reserve(pieces.facets.size());
  for (const std::uint32_t piece : bvh_.order) facets_.push_back(pieces.facets[piece]);
  bvh_.order = {};
}

FacetBvh::Pieces FacetBvh::cut_facets() const {
  constexpr double kRounding = 1e-14;
  const double longest = longest_piece(frame_, points_, tri_to_vert_);
  Pieces pieces;
  for (std::uint32_t tri = 0; tri < tri_to_vert_.size(); ++tri) {
    const Corners corners = corners_in(frame_, points_, tri_to_vert_[tri]);
    const Box3 box = box_of(corners);
    const double rounding = frame_.is_along_axes ? 0 : kRounding * (norm(box.lo) + norm(box.hi));
    const Vec3 margin{rounding, rounding, rounding};
    const std::size_t count = pieces_of(box, longest);
    for (std::size_t i = 0; i < count; ++i) {
      const Box3 part = count == 1 ? box
                                   : box_between(corners, box, static_cast<double>(i) / static_cast<double>(count),
                                                 static_cast<double>(i + 1) / static_cast<double>(count));
      pieces.boxes.push_back({part.lo - margin, part.hi + margin});
      pieces.facets.push_back(tri);
    }
  }
  return pieces;
}

FacetPoint FacetBvh::closest_facing(const Vec3& x, const Vec3& direction, FacetPoint start) const {
  FacetPoint nearest = start;
  double reach2 = reach_of_boxes(start.place.distance2, x);
  visit_nearest_first(
      bvh_, frame_(x), [&] { return reach2; },
      [&](std::uint32_t i) {
        const auto [a, b, c] = tri_to_vert_[facets_[i]];
        const TrianglePoint place = closest_on_triangle(x, points_[a], points_[b], points_[c]);
        const bool is_nearer = place.distance2 < nearest.place.distance2;
        const bool is_as_near = place.distance2 == nearest.place.distance2 && nearest.tri != start.tri;
        if (!is_nearer && !(is_as_near && facets_[i] < nearest.tri)) return;
        const Vec3 normal = cross(points_[b] - points_[a], points_[c] - points_[a]);
        if (dot(normal, direction) < 0) return;
        nearest = {facets_[i], place};
        reach2 = reach_of_boxes(place.distance2, x);
      });
  return nearest;
}

void FacetBvh::for_each_near_ray(const Vec3& origin, const Vec3& direction,
                                 const std::function<void(std::uint32_t)>& visit) const {
  const Vec3 start = frame_(origin), along = frame_(direction);
  any_entered(
      bvh_, [&](const Box3& box) { return ray_touches(start, along, box); },
      [&](std::uint32_t i) {
        visit(facets_[i]);
        return false;
      });
}

}  // namespace tetloom::detail
