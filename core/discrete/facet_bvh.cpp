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
    : points_(points), tri_to_vert_(tri_to_vert), order_(tri_to_vert.size()) {
  std::vector<Vec3> centroids;
  centroids.reserve(tri_to_vert.size());
  for (const Triangle& t : tri_to_vert) centroids.push_back((points[t[0]] + points[t[1]] + points[t[2]]) / 3);
  std::iota(order_.begin(), order_.end(), 0u);
  nodes_.reserve(tri_to_vert.size());
  if (!order_.empty()) build(0, static_cast<std::uint32_t>(order_.size()), centroids);
}

void FacetBvh::build(std::uint32_t begin, std::uint32_t end, std::span<const Vec3> centroids) {
  const std::size_t self = nodes_.size();
  nodes_.emplace_back();
  if (end - begin <= kLeafSize) {
    Box3 box;
    for (std::uint32_t i = begin; i < end; ++i) {
      for (const std::uint32_t v : tri_to_vert_[order_[i]]) box.add(points_[v]);
    }
    nodes_[self] = {box, 0, begin, end - begin};
    return;
  }
  Box3 spread;
  for (std::uint32_t i = begin; i < end; ++i) spread.add(centroids[order_[i]]);
  const Vec3 size = spread.hi - spread.lo;
  const int axis = size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2;
  const std::uint32_t middle = begin + (end - begin) / 2;
  std::nth_element(order_.begin() + begin, order_.begin() + middle, order_.begin() + end,
                   [&](std::uint32_t a, std::uint32_t b) {
                     const double x = centroids[a][axis], y = centroids[b][axis];
                     return x != y ? x < y : a < b;
                   });
  build(begin, middle, centroids);
  const auto second = static_cast<std::uint32_t>(nodes_.size());
  build(middle, end, centroids);
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
  std::array<Entry, kMaxDepth> stack;
  std::size_t depth = 0;
  stack[depth++] = {0, squared_distance_to_box(x, nodes_[0].box)};
  while (depth > 0) {
    const Entry entry = stack[--depth];
    if (!(entry.distance2 < start.distance2)) continue;
    const Node& node = nodes_[entry.node];
    for (std::uint32_t i = node.begin; i < node.begin + node.count; ++i) {
      const Triangle& t = tri_to_vert_[order_[i]];
      FacetPoint candidate = closest_on_triangle(x, points_[t[0]], points_[t[1]], points_[t[2]]);
      candidate.tri = order_[i];
      if (!(candidate.distance2 < start.distance2)) continue;
      const Vec3 normal = cross(points_[t[1]] - points_[t[0]], points_[t[2]] - points_[t[0]]);
      if (!(dot(normal, direction) < 0)) start = candidate;
    }
    if (node.count > 0) continue;
    Entry near{entry.node + 1, squared_distance_to_box(x, nodes_[entry.node + 1].box)};
    Entry far{node.second, squared_distance_to_box(x, nodes_[node.second].box)};
    if (far.distance2 < near.distance2) std::swap(near, far);
    stack[depth++] = far, stack[depth++] = near;
  }
  return start;
}

void FacetBvh::for_each_near_ray(const Vec3& origin, const Vec3& direction,
                                 const std::function<void(std::uint32_t)>& visit) const {
  if (nodes_.empty()) return;
  std::array<std::uint32_t, kMaxDepth> stack;
  std::size_t depth = 0;
  stack[depth++] = 0;
  while (depth > 0) {
    const std::uint32_t index = stack[--depth];
    const Node& node = nodes_[index];
    if (!ray_touches(origin, direction, node.box)) continue;
    for (std::uint32_t i = node.begin; i < node.begin + node.count; ++i) visit(order_[i]);
    if (node.count == 0) stack[depth++] = node.second, stack[depth++] = index + 1;
  }
}

}  // namespace tetloom::detail
