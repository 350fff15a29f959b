#include "core/discrete/facet_bvh.hpp"
#include "core/spatial/distances.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace tetloom::detail {
namespace {

constexpr std::uint32_t kLeafSize = 4;
constexpr std::size_t kMaxDepth = 64;  // halving 2^32 triangles takes 32 levels

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

FacetPoint facet_point(const Vec3& x, const std::array<Vec3, 3>& p, double b1, double b2) {
  FacetPoint result{0xffffffffu, b1, b2, p[0] + b1 * (p[1] - p[0]) + b2 * (p[2] - p[0]), 0};
  result.distance2 = norm2(x - result.point);
  return result;
}

/// Where on the segment from a to b the point nearest to x lies, 0 … 1.
double project_on_segment(const Vec3& x, const Vec3& a, const Vec3& b) {
  const double length2 = norm2(b - a);
  return length2 > 0 ? std::clamp(dot(x - a, b - a) / length2, 0.0, 1.0) : 0.0;
}

/// For a triangle without area: the best of its three sides.
FacetPoint closest_on_sides(const Vec3& x, const std::array<Vec3, 3>& p) {
  const double s01 = project_on_segment(x, p[0], p[1]), s02 = project_on_segment(x, p[0], p[2]);
  const double s12 = project_on_segment(x, p[1], p[2]);
  FacetPoint best = facet_point(x, p, s01, 0);
  for (const FacetPoint& other : {facet_point(x, p, 0, s02), facet_point(x, p, 1 - s12, s12)}) {
    if (other.distance2 < best.distance2) best = other;
  }
  return best;
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

Box3 box_of(const Corners& corners) {
  Box3 box;
  for (const Vec3& p : corners) box.add(p);
  return box;
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

FacetPoint closest_on_triangle(const Vec3& x, const Vec3& p0, const Vec3& p1, const Vec3& p2) {
  const std::array<Vec3, 3> p{p0, p1, p2};
  const Vec3 ab = p1 - p0, ac = p2 - p0, ap = x - p0;
  const double d1 = dot(ab, ap), d2 = dot(ac, ap);
  if (d1 <= 0 && d2 <= 0) return facet_point(x, p, 0, 0);
  const Vec3 bp = x - p1;
  const double d3 = dot(ab, bp), d4 = dot(ac, bp);
  if (d3 >= 0 && d4 <= d3) return facet_point(x, p, 1, 0);
  const Vec3 cp = x - p2;
  const double d5 = dot(ab, cp), d6 = dot(ac, cp);
  if (d6 >= 0 && d5 <= d6) return facet_point(x, p, 0, 1);
  const double va = d3 * d6 - d5 * d4, vb = d5 * d2 - d1 * d6, vc = d1 * d4 - d3 * d2;
  if (vc <= 0 && d1 >= 0 && d3 <= 0 && d1 - d3 > 0) return facet_point(x, p, d1 / (d1 - d3), 0);
  if (vb <= 0 && d2 >= 0 && d6 <= 0 && d2 - d6 > 0) return facet_point(x, p, 0, d2 / (d2 - d6));
  const double on_bc = (d4 - d3) + (d5 - d6);
  if (va <= 0 && d4 - d3 >= 0 && d5 - d6 >= 0 && on_bc > 0) {
    const double s = (d4 - d3) / on_bc;
    return facet_point(x, p, 1 - s, s);
  }
  const double sum = va + vb + vc;
  if (!(va >= 0 && vb >= 0 && vc >= 0 && sum > 0)) return closest_on_sides(x, p);
  return facet_point(x, p, vb / sum, vc / sum);
}

FacetBvh::FacetBvh(std::span<const Vec3> points, std::span<const Triangle> tri_to_vert)
    : frame_(choose_frame(points, tri_to_vert)), points_(points), tri_to_vert_(tri_to_vert) {
  std::vector<Piece> pieces = cut_facets();
  nodes_.reserve(pieces.size());
  if (!pieces.empty()) build(0, static_cast<std::uint32_t>(pieces.size()), pieces);
  for (const Piece& piece : pieces) facets_.push_back(piece.tri);
}

std::vector<FacetBvh::Piece> FacetBvh::cut_facets() const {
  constexpr double kRounding = 1e-14;
  const double longest = longest_piece(frame_, points_, tri_to_vert_);
  std::vector<Piece> pieces;
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
      const Vec3 center = count == 1 ? (corners[0] + corners[1] + corners[2]) / 3 : part.center();
      pieces.push_back({{part.lo - margin, part.hi + margin}, center, tri});
    }
  }
  return pieces;
}

void FacetBvh::build(std::uint32_t begin, std::uint32_t end, std::span<Piece> pieces) {
  const std::size_t self = nodes_.size();
  nodes_.emplace_back();
  if (end - begin <= kLeafSize) {
    Box3 box;
    for (std::uint32_t i = begin; i < end; ++i) box.add(pieces[i].box);
    nodes_[self] = {box, 0, begin, end - begin};
    return;
  }
  Box3 spread;
  for (std::uint32_t i = begin; i < end; ++i) spread.add(pieces[i].center);
  const int axis = longest_axis(spread);
  const std::uint32_t middle = begin + (end - begin) / 2;
  const auto key = [axis](const Piece& piece) { return std::pair(piece.center[axis], piece.tri); };
  std::nth_element(pieces.begin() + begin, pieces.begin() + middle, pieces.begin() + end,
                   [&](const Piece& a, const Piece& b) { return key(a) < key(b); });
  build(begin, middle, pieces);
  const auto second = static_cast<std::uint32_t>(nodes_.size());
  build(middle, end, pieces);
  Box3 box = nodes_[self + 1].box;
  box.add(nodes_[second].box);
  nodes_[self] = {box, second, 0, 0};
}

FacetPoint FacetBvh::closest_facing(const Vec3& x, const Vec3& direction, FacetPoint start) const {
  struct Entry {
    std::uint32_t node;
    double distance2;
  };
  if (nodes_.empty()) return start;
  const Vec3 in_frame = frame_(x);
  std::array<Entry, kMaxDepth> stack;
  std::size_t depth = 0;
  stack[depth++] = {0, squared_distance_to_box(in_frame, nodes_[0].box)};
  while (depth > 0) {
    const Entry entry = stack[--depth];
    if (!(entry.distance2 < start.distance2)) continue;
    const Node& node = nodes_[entry.node];
    for (std::uint32_t i = node.begin; i < node.begin + node.count; ++i) {
      const Triangle& t = tri_to_vert_[facets_[i]];
      FacetPoint candidate = closest_on_triangle(x, points_[t[0]], points_[t[1]], points_[t[2]]);
      candidate.tri = facets_[i];
      if (!(candidate.distance2 < start.distance2)) continue;
      const Vec3 normal = cross(points_[t[1]] - points_[t[0]], points_[t[2]] - points_[t[0]]);
      if (!(dot(normal, direction) < 0)) start = candidate;
    }
    if (node.count > 0) continue;
    Entry near{entry.node + 1, squared_distance_to_box(in_frame, nodes_[entry.node + 1].box)};
    Entry far{node.second, squared_distance_to_box(in_frame, nodes_[node.second].box)};
    if (far.distance2 < near.distance2) std::swap(near, far);
    stack[depth++] = far, stack[depth++] = near;
  }
  return start;
}

void FacetBvh::for_each_near_ray(const Vec3& origin, const Vec3& direction,
                                 const std::function<void(std::uint32_t)>& visit) const {
  if (nodes_.empty()) return;
  const Vec3 start = frame_(origin), along = frame_(direction);
  std::array<std::uint32_t, kMaxDepth> stack;
  std::size_t depth = 0;
  stack[depth++] = 0;
  while (depth > 0) {
    const std::uint32_t index = stack[--depth];
    const Node& node = nodes_[index];
    if (!ray_touches(start, along, node.box)) continue;
    for (std::uint32_t i = node.begin; i < node.begin + node.count; ++i) visit(facets_[i]);
    if (node.count == 0) stack[depth++] = node.second, stack[depth++] = index + 1;
  }
}

}  // namespace tetloom::detail
