#include "mesher/sizing/source_tree.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

namespace tetloom {
namespace {

double distance_to_segment(const Vec3& x, const Vec3& a, const Vec3& b) {
  const Vec3 along = b - a;
  const double length2 = norm2(along);
  const double t = length2 > 0 ? std::clamp(dot(x - a, along) / length2, 0.0, 1.0) : 0;
  return distance(x, a + t * along);
}

Box3 box_of(const SizeSource& source) {
  Box3 box;
  for (const Vec3& p : {source.a, source.b, source.c}) box.add(p);
  return box;
}

}  // namespace

/// By the Voronoi regions of the triangle's vertices, edges and inside (Ericson, Real-Time Collision Detection, 5.1.5).
double distance_to_triangle(const Vec3& x, const Vec3& a, const Vec3& b, const Vec3& c) {
  const Vec3 ab = b - a, ac = c - a, ap = x - a, bp = x - b, cp = x - c;
  const double d1 = dot(ab, ap), d2 = dot(ac, ap), d3 = dot(ab, bp), d4 = dot(ac, bp), d5 = dot(ab, cp),
               d6 = dot(ac, cp);
  if (d1 <= 0 && d2 <= 0) return norm(ap);
  if (d3 >= 0 && d4 <= d3) return norm(bp);
  if (d6 >= 0 && d5 <= d6) return norm(cp);
  const double vc = d1 * d4 - d3 * d2, vb = d5 * d2 - d1 * d6, va = d3 * d6 - d5 * d4;
  if (vc > 0 && vb > 0 && va > 0) {
    const double scale = 1 / (va + vb + vc);
    return norm(ap - (vb * scale) * ab - (vc * scale) * ac);
  }
  return std::min({distance_to_segment(x, a, b), distance_to_segment(x, b, c), distance_to_segment(x, c, a)});
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

double SourceTree::size_from(const SizeSource& source, const Vec3& x) const {
  const double reach = distance_to_triangle(x, source.a, source.b, source.c) - 0.5 * source.size;
  return reach > 0 ? source.size + gradation_ * reach : source.size;
}

/// A source's size rises with s as long as g <= 1, so the smallest s at the nearest distance bounds a whole node.
double SourceTree::bound(std::uint32_t node, const Vec3& x) const {
  const double smallest = node_sizes_[node];
  const double reach = std::sqrt(squared_distance(bvh_.nodes[node].box, x)) - 0.5 * smallest;
  return reach > 0 ? smallest + gradation_ * reach : smallest;
}

double SourceTree::size_at(const Vec3& x, double cap, std::uint32_t& winner) const {
  double best = cap;
  std::uint32_t decider = kNoSource;
  const auto offer = [&](std::uint32_t source) {
    const double size = size_from(sources_[source], x);
    if (size < best) best = size, decider = source;
  };
  if (winner != kNoSource) offer(winner);
  struct Pending {
    std::uint32_t node;
    double bound;
  };
  std::array<Pending, 64> stack;  // a median split halves 2^32 items at most 32 times
  std::size_t count = 0;
  if (!bvh_.nodes.empty()) stack[count++] = {0, bound(0, x)};
  while (count > 0) {
    const Pending top = stack[--count];
    if (top.bound >= best) continue;
    const BvhNode& node = bvh_.nodes[top.node];
    if (node.right == 0) {
      for (std::uint32_t i = node.begin; i < node.end; ++i) offer(i);
      continue;
    }
    Pending near{top.node + 1, bound(top.node + 1, x)}, far{node.right, bound(node.right, x)};
    if (far.bound < near.bound) std::swap(near, far);
    if (far.bound < best) stack[count++] = far;
    if (near.bound < best) stack[count++] = near;
  }
  winner = decider;
  return best;
}

}  // namespace tetloom
