#include <algorithm>
#include <limits>

#include "tetloom/error.hpp"
#include "tetloom/tasks.hpp"
#include "threading/balance/items_detail.hpp"

namespace tetloom::balance_detail {

namespace {

constexpr std::size_t kChunk = std::size_t{1} << 16;
constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// Maxima only, because that is what the ranks can agree on in one call.
struct Extent {
  std::array<double, 9> values{-kInfinity, -kInfinity, -kInfinity, -kInfinity, -kInfinity, -kInfinity, 0, 0, 0};
  double& minus_low(std::size_t axis) { return values[axis]; }
  double& high(std::size_t axis) { return values[3 + axis]; }
  double& weight() { return values[6]; }
  double& weighted() { return values[7]; }
  double& bad() { return values[8]; }
  void merge(const Extent& other) {
    for (std::size_t i = 0; i < values.size(); ++i) values[i] = std::max(values[i], other.values[i]);
  }
};

void measure_points(std::span<const Point3f> points, Extent& extent) {
  std::array<float, 3> low{points[0].x, points[0].y, points[0].z}, high = low;
  bool finite = true;
  for (const Point3f& p : points) {
    const std::array<float, 3> x{p.x, p.y, p.z};
    for (std::size_t axis = 0; axis < 3; ++axis) {
      low[axis] = std::min(low[axis], x[axis]);
      high[axis] = std::max(high[axis], x[axis]);
      finite &= std::abs(x[axis]) <= std::numeric_limits<float>::max();
    }
  }
  for (std::size_t axis = 0; axis < 3; ++axis) {
    extent.minus_low(axis) = std::max(extent.minus_low(axis), -static_cast<double>(low[axis]));
    extent.high(axis) = std::max(extent.high(axis), static_cast<double>(high[axis]));
  }
  if (!finite) extent.bad() = 1;
}

void measure_weights(std::span<const double> weights, Extent& extent) {
  bool good = true;
  double greatest = 0;
  for (const double w : weights) {
    good &= w > 0 && w <= std::numeric_limits<double>::max();
    greatest = std::max(greatest, w);
  }
  extent.weight() = std::max(extent.weight(), greatest);
  if (!good) extent.bad() = 1;
}

bool has_fitting_arrays(const ItemBlock& block) {
  return block.targets.size() == block.points.size() &&
         (block.neighbours.empty() || block.neighbours.size() == 4 * block.points.size()) &&
         (block.weights.empty() || block.weights.size() == block.points.size());
}

}  // namespace

Items::Items(std::span<const ItemBlock> blocks, Communicator& communicator, const TaskRunner& runner)
    : blocks_(blocks), communicator_(&communicator), runner_(&runner) {
  for (std::uint32_t b = 0; b < blocks.size(); ++b)
    for (std::size_t begin = 0; begin < blocks[b].points.size(); begin += kChunk)
      chunks_.push_back({b, begin, std::min(begin + kChunk, blocks[b].points.size())});
  find_extent();
  add_up();
}

void Items::find_extent() {
  std::vector<Extent> extents(lanes(0));
  const bool fitting = std::ranges::all_of(blocks_, has_fitting_arrays);
  if (fitting)
    for_chunks(extents.size(), [&](std::size_t lane, const Chunk& chunk) {
      const ItemBlock& block = blocks_[chunk.block];
      Extent& extent = extents[lane];
      measure_points(block.points.subspan(chunk.begin, chunk.end - chunk.begin), extent);
      if (block.weights.empty()) {
        extent.weight() = std::max(extent.weight(), 1.0);
      } else {
        extent.weighted() = 1;
        measure_weights(block.weights.subspan(chunk.begin, chunk.end - chunk.begin), extent);
      }
    });
  Extent all;
  for (const Extent& extent : extents) all.merge(extent);
  if (!fitting) all.bad() = 1;
  communicator_->max(all.values);
  if (all.bad() > 0)
    throw Error(ErrorCode::InvalidArgument,
                "items to be dealt to parts need finite places, positive finite weights and arrays of one length");
  double longest = 0;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    frame_.low[axis] = -all.minus_low(axis);
    longest = std::max(longest, all.high(axis) - frame_.low[axis]);
  }
  int exponent = 0;
  std::frexp(longest, &exponent);
  frame_.scale = longest > 0 && std::isfinite(longest) ? std::ldexp(1.0, Frame::kPlaceBits - exponent) : 0;
  frame_.weighted = all.weighted() > 0;
  frame_.weight_scale = std::ldexp(1.0, 20) / std::max(all.weight(), 1e-290);  // the quotient must stay finite
}

void Items::add_up() {
  const auto sums = sum_over_items(2, [&](std::span<std::int64_t> sum, const Chunk& chunk) {
    sum[0] += static_cast<std::int64_t>(chunk.end - chunk.begin);
    if (!frame_.weighted) return;
    for (std::size_t i = chunk.begin; i < chunk.end; ++i) sum[1] += frame_.weight_of(blocks_[chunk.block], i);
  });
  count_ = sums[0];
  weight_ = frame_.weighted ? sums[1] : sums[0];
}

std::size_t Items::lanes(std::size_t bytes) const {
  // More lanes than threads even out the load, unless each of them carries much.
  const std::size_t wanted = static_cast<std::size_t>(runner_->threads()) * (bytes > (std::size_t{1} << 17) ? 1 : 4);
  return std::max<std::size_t>(1, std::min(wanted, chunks_.size()));
}

void Items::for_chunks(std::size_t lanes, const std::function<void(std::size_t, const Chunk&)>& body) const {
  runner_->for_each(lanes, [&](std::size_t lane) {
    const std::size_t begin = lane * chunks_.size() / lanes, end = (lane + 1) * chunks_.size() / lanes;
    for (std::size_t c = begin; c < end; ++c) {
      runner_->check_cancelled();
      body(lane, chunks_[c]);
    }
  });
}

std::vector<std::int64_t> Items::sum_over_items(
    std::size_t size, const std::function<void(std::span<std::int64_t>, const Chunk&)>& add) const {
  const std::size_t count = lanes(size * sizeof(std::int64_t));
  std::vector<std::vector<std::int64_t>> sums(count);
  for_chunks(count, [&](std::size_t lane, const Chunk& chunk) {
    sums[lane].resize(size);
    add(sums[lane], chunk);
  });
  sums[0].resize(size);
  for (std::size_t lane = 1; lane < count; ++lane)
    for (std::size_t i = 0; i < sums[lane].size(); ++i) sums[0][i] += sums[lane][i];
  communicator_->sum(sums[0]);
  return std::move(sums[0]);
}

void check_part_count(std::uint64_t part_count) {
  if (part_count == 0) throw Error(ErrorCode::InvalidArgument, "items cannot be dealt to no part at all");
}

void check_ranges(std::span<const ItemBlock> blocks, std::span<const TargetRange> ranges) {
  if (ranges.size() != blocks.size())
    throw Error(ErrorCode::InvalidArgument, "blocks that are split on their own need one range of targets each");
  for (const TargetRange& range : ranges) {
    check_part_count(range.count);
    if (range.count - 1 > std::numeric_limits<std::uint32_t>::max() - range.first)
      throw Error(ErrorCode::InvalidArgument, "a range of targets is longer than 32-bit numbers allow");
  }
}

}  // namespace tetloom::balance_detail
