#include "mesher/parts/own_points.hpp"

#include <algorithm>
#include <queue>
#include <utility>

#include "core/predicates/predicates.hpp"
#include "core/spatial/distances.hpp"

namespace tetloom::parts {

namespace {

constexpr std::uint32_t kLeafPoints = 12;

// What lies nearest comes first; a node before the points in it.
struct Waiting {
  double distance2;
  std::uint32_t index;
  bool is_point;
  friend bool operator<(const Waiting& a, const Waiting& b) {
    if (a.distance2 != b.distance2) return a.distance2 > b.distance2;
    return a.is_point != b.is_point ? a.is_point : a.index > b.index;
  }
};

}  // namespace

OwnPoints::OwnPoints(std::vector<ShellPoint> points) : points_(std::move(points)) {
  std::sort(points_.begin(), points_.end(), [](const ShellPoint& a, const ShellPoint& b) { return a.key < b.key; });
  if (!points_.empty()) build(0, static_cast<std::uint32_t>(points_.size()));
}

std::uint32_t OwnPoints::build(std::uint32_t begin, std::uint32_t end) {
  const auto index = static_cast<std::uint32_t>(nodes_.size());
  Node node{{}, begin, end};
  for (std::uint32_t i = begin; i < end; ++i) node.box.add(points_[i].point);
  nodes_.push_back(node);
  if (end - begin <= kLeafPoints) return index;
  const Vec3 extent = node.box.hi - node.box.lo;
  const int axis = extent.x >= extent.y && extent.x >= extent.z ? 0 : extent.y >= extent.z ? 1 : 2;
  const std::uint32_t middle = begin + (end - begin) / 2;
  std::nth_element(points_.begin() + begin, points_.begin() + middle, points_.begin() + end,
                   [axis](const ShellPoint& a, const ShellPoint& b) {
                     return a.point[axis] != b.point[axis] ? a.point[axis] < b.point[axis] : a.key < b.key;
                   });
  const std::uint32_t low = build(begin, middle), high = build(middle, end);
  nodes_[index].low = low, nodes_[index].high = high;
  return index;
}

void OwnPoints::mark_in(const Doubt& doubt, std::size_t most, std::vector<char>& is_in) const {
  const auto& [a, b, c, d] = doubt.corners;
  const Vec3 middle = 0.25 * (a + b + c + d);
  const double radius2 = doubt.radius * doubt.radius;
  std::priority_queue<Waiting> waiting;
  waiting.push({0, 0, false});
  for (std::size_t inside = 0; !waiting.empty() && inside < most;) {
    const Waiting next = waiting.top();
    waiting.pop();
    if (next.is_point) {
      const int side = insphere(a, b, c, d, points_[next.index].point);
      if (side >= 0) is_in[next.index] = 1;
      inside += side > 0;
      continue;
    }
    const Node& node = nodes_[next.index];
    if (squared_distance_to_box(doubt.center, node.box) > radius2) continue;
    if (node.low != 0) {
      for (const std::uint32_t child : {node.low, node.high})
        waiting.push({squared_distance_to_box(middle, nodes_[child].box), child, false});
      continue;
    }
    for (std::uint32_t i = node.begin; i < node.end; ++i)
      if (norm2(points_[i].point - doubt.center) <= radius2) waiting.push({norm2(points_[i].point - middle), i, true});
  }
}

std::vector<ShellPoint> OwnPoints::find_in(std::span<const Doubt> doubts, std::size_t most_per_doubt) const {
  std::vector<ShellPoint> found;
  if (points_.empty()) return found;
  std::vector<char> is_in(points_.size(), 0);
  for (const Doubt& doubt : doubts) mark_in(doubt, most_per_doubt, is_in);
  for (std::size_t i = 0; i < points_.size(); ++i)
    if (is_in[i]) found.push_back(points_[i]);
  std::sort(found.begin(), found.end(), [](const ShellPoint& s, const ShellPoint& t) { return s.key < t.key; });
  return found;
}

OwnPoints find_own_points(const SharedInput& input, const PartState& state, PartId part) {
  std::vector<ShellPoint> points;
  for_each_own_vert(input, state, part, [&](std::uint32_t v) { points.push_back(shell_point(state, v)); });
  return OwnPoints(std::move(points));
}

}  // namespace tetloom::parts
