#pragma once
// One boundary between two targets: the band of nodes around it, and moves across it.
#include <array>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "tetloom/tasks.hpp"
#include "threading/balance/graph_detail.hpp"

namespace tetloom::balance_detail {

using PartPair = std::array<std::uint32_t, 2>;  ///< ascending

/// Throws InvalidArgument where the arrays do not fit or hold what they must not.
void check_tets(const TargetedTets& tets, const TaskRunner* runner);

inline std::int64_t weight_of(const TargetedTets& tets, std::size_t tet) {
  return tets.weights.empty() ? 1 : tets.weights[tet];
}
std::vector<std::int64_t> weights_by_target(const TargetedTets& tets, const TaskRunner* runner);

/// Queues of free nodes by gain, newest first.
class GainQueues {
 public:
  /// Gains are from -greatest to greatest.
  void reset(std::size_t count, int greatest);
  bool contains(std::uint32_t item) const { return queued_[item]; }
  void push(std::uint32_t item, int gain);
  void remove(std::uint32_t item, int gain);
  /// The newest of the greatest gain, or kNoNode.
  std::uint32_t top();

 private:
  std::uint32_t& head(int gain) { return head_[static_cast<std::size_t>(gain + greatest_)]; }

  int greatest_ = 0, top_ = 0;
  std::vector<std::uint32_t> head_, next_, previous_;
  std::vector<char> queued_;
};

/// Refines one boundary. Between construction and `apply` the nodes' targets are only read, and only those of the pair
/// matter, so that pairs without a common target can be refined at the same time.
template <class Graph>
class PairRefinement {
 public:
  /// `weights`: of both targets.
  PairRefinement(const TargetedGraph<Graph>& nodes, PartPair pair, std::array<std::int64_t, 2> weights,
                 std::int64_t bound, const SmoothingOptions& options);
  /// `seeds`: nodes that may lie at the boundary. `slots`: one per node of the graph, kNoNode at rest; entries of nodes
  /// of the pair are used until it returns.
  void run(std::span<const std::uint32_t> seeds, std::span<std::uint32_t> slots);
  /// Writes the targets; the nodes that have crossed.
  std::vector<std::uint32_t> apply();
  std::array<std::int64_t, 2> weights() const { return weights_; }

 private:
  struct Link {
    std::uint32_t item;
    int links;
  };

  int side_of_node(std::uint32_t node) const;
  bool touches_other_side(std::uint32_t node, int side) const;
  void gather(std::span<const std::uint32_t> seeds, std::span<std::uint32_t> slots);
  void link(std::span<const std::uint32_t> slots);
  bool pass();
  void fill_queues();
  std::uint32_t pick();
  std::uint32_t top_that_may_move(int side);
  bool may_leave(int side, std::int64_t weight) const;
  void move(std::uint32_t item, bool undo);
  void change_gain(std::uint32_t item, int change, bool undo);

  const TargetedGraph<Graph>& nodes_;
  PartPair pair_;
  std::array<std::int64_t, 2> weights_;
  std::int64_t bound_, lightest_ = 0;
  SmoothingOptions options_;
  std::vector<std::uint32_t> band_;   // nodes
  std::vector<std::uint32_t> first_;  // by item: where its links begin
  std::vector<Link> links_;
  std::vector<int> degree_, gain_;
  std::vector<std::int8_t> side_;
  std::vector<char> locked_;
  std::array<GainQueues, 2> queues_;
  std::size_t boundary_count_ = 0;
};

}  // namespace tetloom::balance_detail
