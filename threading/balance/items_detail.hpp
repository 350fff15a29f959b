#pragma once
// What the geometric partitioners share: loops over all items, exact weights, quantised places.
#include <array>
#include <cmath>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "tetloom/tasks.hpp"
#include "threading/balance/partitioners.hpp"

namespace tetloom::balance_detail {

/// A stretch of one block.
struct Chunk {
  std::uint32_t block;
  std::size_t begin, end;
};

/// How places and weights become integers. Loops keep a copy, which no store to an array can be taken to change.
struct Frame {
  static constexpr int kPlaceBits = 30;

  std::array<double, 3> low{};
  double scale = 1;
  double weight_scale = 1;
  bool weighted = false;

  std::int64_t weight_of(const ItemBlock& block, std::size_t i) const {
    return weighted ? round_weight(block.weights.empty() ? 1 : block.weights[i]) : 1;
  }
  /// In [0, 2^30) along each axis, on one scale for all three.
  std::array<std::int64_t, 3> place_of(const Point3f& p) const {
    return {static_cast<std::int64_t>((static_cast<double>(p.x) - low[0]) * scale),
            static_cast<std::int64_t>((static_cast<double>(p.y) - low[1]) * scale),
            static_cast<std::int64_t>((static_cast<double>(p.z) - low[2]) * scale)};
  }

 private:
  std::int64_t round_weight(double w) const {
    const auto multiple = static_cast<std::int64_t>(w * weight_scale + 0.5);
    return multiple > 1 ? multiple : 1;
  }
};

/// All items of a run: where they lie, how places and weights become integers, and how loops over them are cut.
class Items {
 public:
  /// Checks the input. Errors: InvalidArgument, on all ranks alike.
  Items(std::span<const ItemBlock> blocks, Communicator& communicator, const TaskRunner& runner);

  std::span<const ItemBlock> blocks() const { return blocks_; }
  const Frame& frame() const { return frame_; }
  const TaskRunner& runner() const { return *runner_; }
  Communicator& communicator() const { return *communicator_; }
  std::int64_t count() const { return count_; }    ///< on all ranks
  std::int64_t weight() const { return weight_; }  ///< of all items, in multiples

  /// How many lanes a loop should have that keeps `bytes` per lane.
  std::size_t lanes(std::size_t bytes) const;
  /// body(lane, chunk) for all chunks; those of one lane run one after another.
  void for_chunks(std::size_t lanes, const std::function<void(std::size_t, const Chunk&)>& body) const;
  /// Adds up one histogram per lane, and then those of all ranks.
  std::vector<std::int64_t> sum_over_items(std::size_t size,
                                           const std::function<void(std::span<std::int64_t>, const Chunk&)>& add) const;

 private:
  void find_extent();
  void add_up();

  std::span<const ItemBlock> blocks_;
  Communicator* communicator_;
  const TaskRunner* runner_;
  std::vector<Chunk> chunks_;
  Frame frame_;
  std::int64_t count_ = 0, weight_ = 0;
};

/// Throws unless there is at least one target.
void check_part_count(std::uint64_t part_count);
/// Throws unless there is one range for each block, none of them empty.
void check_ranges(std::span<const ItemBlock> blocks, std::span<const TargetRange> ranges);

}  // namespace tetloom::balance_detail
