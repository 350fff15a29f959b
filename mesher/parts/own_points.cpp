#include "mesher/parts/own_points.hpp"

#include <algorithm>
#include <queue>
#include <utility>

#include "core/predicates/predicates.hpp"
#include "core/spatial/distances.hpp"
#include "tetloom/host.hpp"

namespace tetloom::parts {

namespace {

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
  std::vector<Box3> boxes(points_.size());
  for (std::size_t i = 0; i < points_.size(); ++i) boxes[i].add(points_[i].point);
  bvh_ = build_bvh(boxes, serial_loop());
}

void OwnPoints::mark_in(const OpenBall& ball, std::size_t most, std::vector<char>& is_in) const {
  const auto& [a, b, c, d] = ball.corners;
  const Vec3 middle = 0.25 * (a + b + c + d);
  const double radius2 = ball.radius * ball.radius;
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
    const BvhNode& node = bvh_.nodes[next.index];
    if (squared_distance_to_box(ball.center, node.box) > radius2) continue;
    if (node.right != 0) {
      for (const std::uint32_t child : {next.index + 1, node.right})
        waiting.push({squared_distance_to_box(middle, bvh_.nodes[child].box), child, false});
      continue;
    }
    for (const std::uint32_t i : std::span(bvh_.order).subspan(node.begin, node.end - node.begin))
      if (norm2(points_[i].point - ball.center) <= radius2) waiting.push({norm2(points_[i].point - middle), i, true});
  }
}

std::vector<ShellPoint> OwnPoints::find_in(std::span<const OpenBall> open_balls, std::size_t most_per_ball) const {
  std::vector<ShellPoint> found;
  if (points_.empty()) return found;
  std::vector<char> is_in(points_.size(), 0);
  for (const OpenBall& ball : open_balls) mark_in(ball, most_per_ball, is_in);
  for (std::size_t i = 0; i < points_.size(); ++i)
    if (is_in[i]) found.push_back(points_[i]);
  return found;
}

OwnPoints find_own_points(const SharedInput& input, const PartShell& shell, PartId part) {
  std::vector<ShellPoint> points;
  for_each_own_vert(input, shell, part, [&](std::uint32_t v) { points.push_back(shell_point(shell, v)); });
  return OwnPoints(std::move(points));
}

}  // namespace tetloom::parts
