#include <algorithm>
#include <array>
#include <utility>

#include "tetloom/tasks.hpp"
#include "threading/balance/aggregation_detail.hpp"

namespace tetloom::balance_detail {

namespace {

constexpr int kMaxDepth = 8;
constexpr std::size_t kLeast = std::size_t{1} << 15;  // items of a chunk
constexpr std::size_t kSample = std::size_t{1} << 14;

/// A complete tree of planes normal to the axes; node i has the children 2i + 1 and 2i + 2.
class PlaneTree {
 public:
  PlaneTree(std::span<const Point3f> points, int depth) : depth_(depth), planes_((std::size_t{1} << depth) - 1) {
    std::vector<std::array<float, 3>> sample;
    const std::size_t step = std::max<std::size_t>(1, points.size() / kSample);
    for (std::size_t i = 0; i < points.size(); i += step) sample.push_back({points[i].x, points[i].y, points[i].z});
    if (depth > 0) cut(0, sample);
  }

  std::uint32_t find_leaf(const Point3f& point) const {
    const std::array<float, 3> x{point.x, point.y, point.z};
    std::size_t node = 0;
    for (int level = 0; level < depth_; ++level) node = 2 * node + (x[planes_[node].axis] < planes_[node].at ? 1 : 2);
    return static_cast<std::uint32_t>(node - planes_.size());
  }

 private:
  struct Plane {
    std::uint32_t axis = 0;
    float at = 0;
  };

  void cut(std::size_t node, std::span<std::array<float, 3>> sample) {
    if (node >= planes_.size() || sample.empty()) return;
    std::array<float, 3> low = sample[0], high = low;
    for (const auto& x : sample)
      for (std::size_t axis = 0; axis < 3; ++axis) {
        low[axis] = std::min(low[axis], x[axis]);
        high[axis] = std::max(high[axis], x[axis]);
      }
    std::uint32_t axis = 0;
    for (std::uint32_t other = 1; other < 3; ++other)
      if (high[other] - low[other] > high[axis] - low[axis]) axis = other;
    const std::size_t half = sample.size() / 2;
    std::nth_element(sample.begin(), sample.begin() + static_cast<std::ptrdiff_t>(half), sample.end(),
                     [axis](const auto& a, const auto& b) { return a[axis] < b[axis]; });
    planes_[node] = {axis, sample[half][axis]};
    cut(2 * node + 1, sample.first(half));
    cut(2 * node + 2, sample.subspan(half));
  }

  int depth_;
  std::vector<Plane> planes_;
};

}  // namespace

Chunks find_chunks(std::vector<Point3f> points, std::span<std::uint32_t> chunk_of, const TaskRunner& runner) {
  const std::size_t items = points.size();
  int depth = 0;
  while (depth < kMaxDepth && items >> (depth + 1) >= kLeast) ++depth;
  const PlaneTree tree(points, depth);
  const std::size_t count = std::size_t{1} << depth, blocks = (items + kNodeGrain - 1) / kNodeGrain;
  std::vector<std::vector<std::uint32_t>> at(blocks);  // by block and chunk: first how many, then where
  runner.for_blocks(items, kNodeGrain, [&](std::size_t begin, std::size_t end) {
    std::vector<std::uint32_t>& counts = at[begin / kNodeGrain];
    counts.assign(count, 0);
    for (std::size_t i = begin; i < end; ++i) ++counts[chunk_of[i] = tree.find_leaf(points[i])];
  });
  std::vector<Point3f>().swap(points);
  Chunks chunks;
  std::uint32_t sum = 0;
  for (std::size_t c = 0; c < count; ++c) {
    for (auto& counts : at) sum += std::exchange(counts[c], sum);
    chunks.begin.push_back(sum);
  }
  chunks.nodes.resize(items);
  runner.for_blocks(items, kNodeGrain, [&](std::size_t begin, std::size_t end) {
    std::vector<std::uint32_t>& next = at[begin / kNodeGrain];
    for (std::size_t i = begin; i < end; ++i) chunks.nodes[next[chunk_of[i]]++] = static_cast<std::uint32_t>(i);
  });
  return chunks;
}

}  // namespace tetloom::balance_detail
