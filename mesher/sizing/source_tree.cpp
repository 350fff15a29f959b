#include "mesher/sizing/source_tree.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

namespace tetloom {
namespace {

/// Squared distance from `x` to a b, given ap = x - a and the dot products of ab with ap and with itself.
double squared_to_segment(const Vec3& ap, const Vec3& ab, double along, double length2) {
  const double t = length2 > 0 ? std::clamp(along / length2, 0.0, 1.0) : 0;
  return norm2(ap - t * ab);
}

Box3 box_of(const SizeSource& source) {
  Box3 box;
  for (const Vec3& p : {source.a, source.b, source.c}) box.add(p);
  return box;
}

/// By the signs of the barycentric coordinates (Ericson, Real-Time Collision Detection, 5.1.5): outside of the triangle
/// the nearest point lies on an edge. `area2` is ab2 ac2 - abac², or 0 where a triangle is a segment or a point.
struct PreparedTriangle {
  const Vec3 &ab, &ac;
  double ab2, ac2, abac, area2;

  double squared_distance(const Vec3& ap) const {
    const double d1 = dot(ab, ap), d2 = dot(ac, ap);
    if (d1 <= 0 && d2 <= 0) return norm2(ap);
    const double v = d1 * ac2 - d2 * abac, w = d2 * ab2 - d1 * abac;
    if (v >= 0 && w >= 0 && v + w <= area2 && area2 > 0) return norm2(ap - (v / area2) * ab - (w / area2) * ac);
    double best = squared_to_segment(ap, ab, d1, ab2);
    if (area2 == 0) return best;
    best = std::min(best, squared_to_segment(ap, ac, d2, ac2));
    return std::min(best, squared_to_segment(ap - ab, ac - ab, d2 - d1 - abac + ab2, ab2 + ac2 - 2 * abac));
  }
};

}  // namespace

SourceTree::SourceTree(std::vector<SizeSource> sources, double gradation, const TaskRunner& runner)
    : gradation_(gradation) {
  std::vector<Box3> boxes(sources.size());
  runner.for_blocks(sources.size(), 4096, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) boxes[i] = box_of(sources[i]);
  });
  bvh_ = build_bvh(boxes, runner);
  sources_.resize(sources.size());
  runner.for_blocks(sources.size(), 4096, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) sources_[i] = prepare(sources[bvh_.order[i]]);
  });
  bounds_.resize(bvh_.nodes.size());
  for (std::size_t i = bvh_.nodes.size(); i-- > 0;) {
    const BvhNode& node = bvh_.nodes[i];
    NodeBounds& bounds = bounds_[i];
    if (node.right != 0) {
      bounds.size = std::min(bounds_[i + 1].size, bounds_[node.right].size);
      bounds.hold = std::max(bounds_[i + 1].hold, bounds_[node.right].hold);
      continue;
    }
    for (std::uint32_t j = node.begin; j < node.end; ++j) {
      bounds.size = std::min(bounds.size, sources_[j].size);
      bounds.hold = std::max(bounds.hold, sources_[j].hold);
    }
  }
}

SourceTree::Triangle SourceTree::prepare(const SizeSource& source) {
  Triangle triangle;
  triangle.center = (source.a + source.b + source.c) / 3.0;
  for (const Vec3& corner : {source.a, source.b, source.c})
    triangle.radius = std::max(triangle.radius, distance(triangle.center, corner));
  triangle.a = source.a;
  triangle.ab = source.b - source.a;
  triangle.ac = source.c - source.a;
  triangle.size = source.size;
  triangle.ab2 = norm2(triangle.ab);
  triangle.ac2 = norm2(triangle.ac);
  triangle.abac = dot(triangle.ab, triangle.ac);
  const bool segment = source.b == source.c;
  triangle.area2 = segment ? 0 : triangle.ab2 * triangle.ac2 - triangle.abac * triangle.abac;
  const double share = !segment ? 0.6 : source.a != source.b ? 0.75 : 0.95;
  triangle.hold = source.hold > 0 ? source.hold : share * source.size;
  return triangle;
}

// In a ball a source comes nearer by the radius, as if it held that much further.
double SourceTree::least_within(const Vec3& x, double radius, double cap, std::uint32_t& winner) const {
  double best = cap;
  std::uint32_t decider = kNoSource;
  // A source gives less than `best` only within the distance (best - s) / g + hold + radius.
  const double per_growth = 1 / gradation_;
  const auto is_near = [&](std::uint32_t node, double distance2) {
    if (bounds_[node].size >= best) return false;
    const double reach = (best - bounds_[node].size) * per_growth + bounds_[node].hold + radius;
    return distance2 < reach * reach;
  };
  const auto offer = [&](std::uint32_t i) {
    const Triangle& t = sources_[i];
    if (t.size >= best) return;
    const double reach = (best - t.size) * per_growth + t.hold + radius, to_center = reach + t.radius;
    if (norm2(x - t.center) >= to_center * to_center) return;
    const PreparedTriangle prepared{t.ab, t.ac, t.ab2, t.ac2, t.abac, t.area2};
    const double distance2 = prepared.squared_distance(x - t.a);
    if (distance2 >= reach * reach) return;
    best = t.size + gradation_ * std::max(0.0, std::sqrt(distance2) - t.hold - radius);
    decider = i;
  };
  if (winner != kNoSource) offer(winner);
  struct Pending {
    std::uint32_t node;
    double distance2;
  };
  std::array<Pending, 64> stack;  // median splits halve 2^32 items at most 32 times
  std::size_t count = 0;
  if (!bvh_.nodes.empty()) stack[count++] = {0, squared_distance(bvh_.nodes[0].box, x)};
  while (count > 0) {
    const Pending top = stack[--count];
    if (!is_near(top.node, top.distance2)) continue;
    const BvhNode& node = bvh_.nodes[top.node];
    if (node.right == 0) {
      for (std::uint32_t i = node.begin; i < node.end; ++i) offer(i);
      continue;
    }
    Pending near{top.node + 1, squared_distance(bvh_.nodes[top.node + 1].box, x)};
    Pending far{node.right, squared_distance(bvh_.nodes[node.right].box, x)};
    if (far.distance2 < near.distance2) std::swap(near, far);
    if (is_near(far.node, far.distance2)) stack[count++] = far;
    if (is_near(near.node, near.distance2)) stack[count++] = near;
  }
  winner = decider;
  return best;
}

}  // namespace tetloom
