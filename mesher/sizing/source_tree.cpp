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

}  // namespace

/// By the signs of the barycentric coordinates (Ericson, Real-Time Collision Detection, 5.1.5): outside of the triangle
/// the nearest point lies on one of the edges that the projection of `x` sees from outside.
double squared_distance_to_triangle(const Vec3& x, const Vec3& a, const Vec3& b, const Vec3& c) {
  const Vec3 ab = b - a, ac = c - a, ap = x - a;
  const double d1 = dot(ab, ap), d2 = dot(ac, ap);
  if (d1 <= 0 && d2 <= 0) return norm2(ap);
  const double ab2 = norm2(ab), ac2 = norm2(ac), abac = dot(ab, ac);
  const double v = d1 * ac2 - d2 * abac, w = d2 * ab2 - d1 * abac, area = ab2 * ac2 - abac * abac;
  if (v >= 0 && w >= 0 && v + w <= area && area > 0) return norm2(ap - (v / area) * ab - (w / area) * ac);
  double best = squared_to_segment(ap, ab, d1, ab2);
  best = std::min(best, squared_to_segment(ap, ac, d2, ac2));
  const Vec3 bc = c - b, bp = x - b;
  return std::min(best, squared_to_segment(bp, bc, dot(bc, bp), norm2(bc)));
}

SourceTree::SourceTree(std::vector<SizeSource> sources, double gradation, const TaskRunner& runner)
    : gradation_(gradation) {
  std::vector<Box3> boxes(sources.size());
  runner.for_blocks(sources.size(), 4096, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) boxes[i] = box_of(sources[i]);
  });
  bvh_ = build_bvh(boxes, runner);
  sources_.reserve(sources.size());
  for (const std::uint32_t i : bvh_.order) sources_.push_back(sources[i]);
  node_sizes_.resize(bvh_.nodes.size());
  for (std::size_t i = bvh_.nodes.size(); i-- > 0;) {
    const BvhNode& node = bvh_.nodes[i];
    double smallest = HUGE_VAL;
    if (node.right != 0)
      smallest = std::min(node_sizes_[i + 1], node_sizes_[node.right]);
    else
      for (std::uint32_t j = node.begin; j < node.end; ++j) smallest = std::min(smallest, sources_[j].size);
    node_sizes_[i] = smallest;
  }
}

double SourceTree::size_at(const Vec3& x, double cap, std::uint32_t& winner) const {
  double best = cap;
  std::uint32_t decider = kNoSource;
  // A source of size s gives less than `best` within the distance (best - s) / g + s/2 only; this shrinks as s grows
  // because g <= 1, so the smallest s bounds a whole node.
  const double per_growth = 1 / gradation_;
  const auto reach2 = [&](double smallest) {
    if (smallest >= best) return -1.0;
    const double reach = (best - smallest) * per_growth + kHold * smallest;
    return reach * reach;
  };
  const auto offer = [&](std::uint32_t i) {
    const SizeSource& source = sources_[i];
    const double distance2 = squared_distance_to_triangle(x, source.a, source.b, source.c);
    if (distance2 >= reach2(source.size)) return;
    best = source.size + gradation_ * std::max(0.0, std::sqrt(distance2) - kHold * source.size);
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
    if (top.distance2 >= reach2(node_sizes_[top.node])) continue;
    const BvhNode& node = bvh_.nodes[top.node];
    if (node.right == 0) {
      for (std::uint32_t i = node.begin; i < node.end; ++i) offer(i);
      continue;
    }
    Pending near{top.node + 1, squared_distance(bvh_.nodes[top.node + 1].box, x)};
    Pending far{node.right, squared_distance(bvh_.nodes[node.right].box, x)};
    if (far.distance2 < near.distance2) std::swap(near, far);
    if (far.distance2 < reach2(node_sizes_[far.node])) stack[count++] = far;
    if (near.distance2 < reach2(node_sizes_[near.node])) stack[count++] = near;
  }
  winner = decider;
  return best;
}

}  // namespace tetloom
