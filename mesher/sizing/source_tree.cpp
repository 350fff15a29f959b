#include "mesher/sizing/source_tree.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "tetloom/tasks.hpp"

namespace tetloom {
namespace {

// Of single precision, a few times.
constexpr float kRounding = 2e-6f;

/// From `x` to boxes side by side.
template <class Lanes>
Lanes squared_distances(const std::array<Lanes, 3>& lo, const std::array<Lanes, 3>& hi, const std::array<float, 3>& x) {
  Lanes sum{};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const Lanes before = lo[axis] - x[axis], beyond = x[axis] - hi[axis];
    Lanes outside = before > beyond ? before : beyond;
    outside = outside > 0 ? outside : Lanes{};
    sum += outside * outside;
  }
  return sum;
}

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
  if (sources.empty()) return;
  std::vector<Box3> boxes(sources.size());
  runner.for_blocks(sources.size(), 4096, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) boxes[i] = box_of(sources[i]);
  });
  const Bvh bvh = build_bvh(boxes, runner);
  sources_.resize(sources.size());
  runner.for_blocks(sources.size(), 4096, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) sources_[i] = prepare(sources[bvh.order[i]]);
  });
  for (const Triangle& source : sources_) smallest_ = std::min(smallest_, source.size);
  origin_ = bvh.nodes[0].box.center();
  slack_ = static_cast<float>(kRounding * bvh.nodes[0].box.diagonal());
  add_node(bvh, 0);
}

/// Below `root` come its grandchildren, and children that are leaves. Returns the number of the node.
std::uint32_t SourceTree::add_node(const Bvh& bvh, std::uint32_t root) {
  std::array<std::uint32_t, Node::kWidth> below{root};
  std::size_t count = 1;
  for (int generation = 0; generation < 2; ++generation)
    for (std::size_t i = 0, end = count; i < end; ++i) {
      if (bvh.nodes[below[i]].right == 0) continue;
      below[count++] = bvh.nodes[below[i]].right;
      ++below[i];
    }
  const auto number = static_cast<std::uint32_t>(nodes_.size());
  nodes_.emplace_back();
  Node node;
  for (std::size_t i = 0; i < Node::kWidth; ++i) {
    set_child(node, i, bvh, below[std::min(i, count - 1)]);
    if (i >= count) node.size[i] = HUGE_VALF;  // never met
    if (i < count && bvh.nodes[below[i]].right != 0) node.child[i] = add_node(bvh, below[i]);
  }
  nodes_[number] = node;
  return number;
}

void SourceTree::set_child(Node& node, std::size_t place, const Bvh& bvh, std::uint32_t child) const {
  const BvhNode& from = bvh.nodes[child];
  const auto below = [](double value) { return std::nextafter(static_cast<float>(value), -HUGE_VALF); };
  for (int axis = 0; axis < 3; ++axis) {
    const auto a = static_cast<std::size_t>(axis);
    node.lo[a][place] = below(from.box.lo[axis] - origin_[axis]);
    node.hi[a][place] = -below(origin_[axis] - from.box.hi[axis]);
  }
  double size = HUGE_VAL, base = HUGE_VAL;
  for (std::uint32_t i = from.begin; i < from.end; ++i) {
    size = std::min(size, sources_[i].size);
    base = std::min(base, sources_[i].size - gradation_ * sources_[i].hold);
  }
  node.size[place] = below(size);
  node.base[place] = below(base);
  node.child[place] = Node::kLeaf | from.begin;
  node.count[place] = static_cast<std::uint8_t>(from.right == 0 ? from.end - from.begin : 0);
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
  const double per_growth = 1 / gradation_;
  const auto offer = [&](std::uint32_t i) {
    const Triangle& t = sources_[i];
    if (t.size >= best) return;
    // A source gives less than `best` only within this distance.
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
    float distance2, size, base;
    std::uint32_t child, count;
  };
  std::array<Pending, 64> stack;  // of 4^16 leaves, three wait on every level
  std::size_t waiting = 0;
  const auto push = [&](const Pending& pending, std::size_t lowest) {  // the nearest on top
    std::size_t at = waiting++;
    for (; at > lowest && stack[at - 1].distance2 < pending.distance2; --at) stack[at] = stack[at - 1];
    stack[at] = pending;
  };
  if (!nodes_.empty()) push({0, 0, 0, 0, 0}, 0);
  const Vec3 seen = x - origin_;
  const std::array<float, 3> place{static_cast<float>(seen.x), static_cast<float>(seen.y), static_cast<float>(seen.z)};
  const auto growths = static_cast<float>(per_growth);
  const auto further = static_cast<float>(radius) + slack_;
  while (waiting > 0) {
    const Pending top = stack[--waiting];
    const float highest = static_cast<float>(best) * (1 + kRounding), reach = (highest - top.base) * growths + further;
    if (top.size >= highest || top.distance2 >= reach * reach) continue;
    if (top.child & Node::kLeaf) {
      const std::uint32_t first = top.child & ~Node::kLeaf;
      for (std::uint32_t i = first; i < first + top.count; ++i) offer(i);
      continue;
    }
    const Node& node = nodes_[top.child];
    const Node::Lanes distance2 = squared_distances(node.lo, node.hi, place);
    const Node::Lanes reaches = (highest - node.base) * growths + further;
    const auto near = (distance2 < reaches * reaches) & (node.size < highest);
    const std::size_t lowest = waiting;
    for (std::size_t i = 0; i < Node::kWidth; ++i)
      if (near[i]) push({distance2[i], node.size[i], node.base[i], node.child[i], node.count[i]}, lowest);
  }
  winner = decider;
  return best;
}

}  // namespace tetloom
