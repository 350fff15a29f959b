#pragma once
// One boundary between two targets: the band of tets around it, and moves across it.
#include <array>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "threading/balance/part_boundaries.hpp"

namespace tetloom::balance_detail {

using PartPair = std::array<std::uint32_t, 2>;  ///< ascending

/// Throws InvalidArgument where the arrays do not fit or hold what they must not.
void check_tets(const TargetedTets& tets, const TaskRunner* runner);

inline std::int64_t weight_of(const TargetedTets& tets, std::size_t tet) {
  return tets.weights.empty() ? 1 : tets.weights[tet];
}
std::vector<std::int64_t> weights_by_target(const TargetedTets& tets, const TaskRunner* runner);

/// Queues of free tets by gain, newest first.
class GainQueues {
 public:
  static constexpr int kMaxGain = 4;
  static constexpr std::uint32_t kNone = 0xffffffff;

  void reset(std::size_t count);
  bool contains(std::uint32_t item) const { return queued_[item]; }
  void push(std::uint32_t item, int gain);
  void remove(std::uint32_t item, int gain);
  /// The newest of the greatest gain, or kNone.
  std::uint32_t top();
  int top_gain() const { return top_; }

 private:
  std::array<std::uint32_t, 2 * kMaxGain + 1> head_{};
  int top_ = -kMaxGain;
  std::vector<std::uint32_t> next_, previous_;
  std::vector<char> queued_;
};

/// Refines one boundary. Between construction and `apply` the tets' targets are only read, and only those of the pair
/// matter, so that pairs without a common target can be refined at the same time.
class PairRefinement {
 public:
  /// `seeds`: tets that may lie at the boundary. `slots`: one per tet of the block, kNone at rest; entries of tets of
  /// the pair are used until `apply`.
  PairRefinement(const TargetedTets& tets, PartPair pair, std::array<std::int64_t, 2> weights, std::int64_t bound,
                 const SmoothingOptions& options);
  void run(std::span<const std::uint32_t> seeds, std::span<std::uint32_t> slots);
  /// Writes the targets and calls moved(tet) for each tet that has crossed.
  std::vector<std::uint32_t> apply();
  std::array<std::int64_t, 2> weights() const { return weights_; }

 private:
  int side_of_tet(std::uint32_t tet) const;
  bool touches_other_side(std::uint32_t tet, int side) const;
  void gather(std::span<const std::uint32_t> seeds, std::span<std::uint32_t> slots);
  void link(std::span<std::uint32_t> slots);
  bool pass();
  void fill_queues();
  std::uint32_t pick();
  bool may_move(std::uint32_t item) const;
  void move(std::uint32_t item, bool undo);
  void change_gain(std::uint32_t item, int change, bool undo);

  const TargetedTets& tets_;
  PartPair pair_;
  std::array<std::int64_t, 2> weights_;
  std::int64_t bound_;
  SmoothingOptions options_;
  std::vector<std::uint32_t> band_;                       // tets
  std::vector<std::array<std::uint32_t, 4>> neighbours_;  // in the band
  std::vector<std::int8_t> side_, degree_, gain_;
  std::vector<char> locked_;
  std::array<GainQueues, 2> queues_;
  std::size_t boundary_count_ = 0;
};

}  // namespace tetloom::balance_detail
