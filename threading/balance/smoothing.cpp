#include <algorithm>
#include <atomic>
#include <cmath>
#include <map>
#include <numeric>
#include <optional>

#include "tetloom/error.hpp"
#include "tetloom/tasks.hpp"
#include "threading/balance/pair_refinement_detail.hpp"

namespace tetloom {

namespace balance_detail {

namespace {

using Seeds = std::map<PartPair, std::vector<std::uint32_t>>;

PartPair ordered(std::uint32_t a, std::uint32_t b) { return a < b ? PartPair{a, b} : PartPair{b, a}; }

/// Adds a node to the seeds of each boundary that it lies at.
template <class Graph>
void add_seed(const TargetedGraph<Graph>& nodes, std::uint32_t node, Seeds& seeds) {
  const std::uint32_t own = nodes.targets[node];
  nodes.graph.for_links(node, [&](std::uint32_t other, std::uint32_t) {
    if (nodes.targets[other] == own) return;
    auto& list = seeds[ordered(own, nodes.targets[other])];
    if (list.empty() || list.back() != node) list.push_back(node);
  });
}

template <class Graph>
Seeds find_seeds(const TargetedGraph<Graph>& nodes, const TaskRunner& runner) {
  std::vector<Seeds> by_block((nodes.targets.size() + kNodeGrain - 1) / kNodeGrain);
  runner.for_blocks(nodes.targets.size(), kNodeGrain, [&](std::size_t begin, std::size_t end) {
    for (std::size_t node = begin; node < end; ++node)
      add_seed(nodes, static_cast<std::uint32_t>(node), by_block[begin / kNodeGrain]);
  });
  Seeds seeds;
  for (Seeds& block : by_block)
    for (auto& [pair, list] : block) {
      auto& all = seeds[pair];
      all.insert(all.end(), list.begin(), list.end());
    }
  return seeds;
}

/// `weight_of_node(i)` summed by target.
template <class WeightOfNode>
std::vector<std::int64_t> sum_by_target(std::span<const std::uint32_t> targets, std::uint32_t part_count,
                                        const TaskRunner* runner, const WeightOfNode& weight_of_node) {
  const std::size_t count = targets.size(), lanes = runner ? static_cast<std::size_t>(runner->threads()) : 1;
  std::vector<std::vector<std::int64_t>> sums(lanes, std::vector<std::int64_t>(part_count, 0));
  const auto add = [&](std::size_t lane) {
    for (std::size_t i = lane * count / lanes; i < (lane + 1) * count / lanes; ++i)
      sums[lane][targets[i]] += weight_of_node(static_cast<std::uint32_t>(i));
  };
  runner ? runner->for_each(lanes, add) : add(0);
  for (std::size_t lane = 1; lane < lanes; ++lane)
    for (std::size_t p = 0; p < part_count; ++p) sums[0][p] += sums[lane][p];
  return std::move(sums[0]);
}

/// Boundaries without common targets, long ones first; takes them out of `waiting`.
std::vector<PartPair> take_independent(std::vector<PartPair>& waiting, std::uint32_t part_count) {
  std::vector<char> busy(part_count, 0);
  std::vector<PartPair> taken, left;
  for (const PartPair& pair : waiting) {
    const bool free = !busy[pair[0]] && !busy[pair[1]];
    (free ? taken : left).push_back(pair);
    if (free) busy[pair[0]] = busy[pair[1]] = 1;
  }
  waiting = std::move(left);
  return taken;
}

template <class Graph>
class Smoothing {
 public:
  Smoothing(const TargetedGraph<Graph>& nodes, const TaskRunner& runner, const SmoothingOptions& options)
      : nodes_(nodes),
        runner_(runner),
        options_(options),
        weights_(sum_by_target(nodes.targets, nodes.part_count, &runner,
                               [&](std::uint32_t node) { return nodes.graph.weight(node); })),
        bound_(bound_of(weights_, options.imbalance)) {
    slots_.resize(nodes.targets.size());
    runner.for_blocks(slots_.size(), kNodeGrain, [&](std::size_t begin, std::size_t end) {
      std::fill(slots_.begin() + begin, slots_.begin() + end, kNoNode);
    });
    seeds_ = find_seeds(nodes, runner);
  }

  void sweep() {
    std::vector<PartPair> waiting;
    for (const auto& [pair, list] : seeds_) waiting.push_back(pair);
    std::stable_sort(waiting.begin(), waiting.end(),
                     [&](const PartPair& a, const PartPair& b) { return seeds_[a].size() > seeds_[b].size(); });
    while (!waiting.empty()) refine(take_independent(waiting, nodes_.part_count));
  }

 private:
  void refine(std::span<const PartPair> pairs) {
    std::vector<std::optional<PairRefinement<Graph>>> work(pairs.size());
    std::vector<std::vector<std::uint32_t>> moved(pairs.size());
    runner_.for_each(pairs.size(), [&](std::size_t i) {
      const auto [a, b] = pairs[i];
      work[i].emplace(nodes_, pairs[i], std::array{weights_[a], weights_[b]}, bound_, options_);
      work[i]->run(seeds_.at(pairs[i]), slots_);
    });
    // Targets are written only here: while bands are gathered, a band reads the targets of nodes of other pairs.
    runner_.for_each(pairs.size(), [&](std::size_t i) { moved[i] = work[i]->apply(); });
    for (std::size_t i = 0; i < pairs.size(); ++i) {
      for (int side = 0; side < 2; ++side) weights_[pairs[i][side]] = work[i]->weights()[side];
      for (const std::uint32_t node : moved[i]) seed_around(node);
    }
  }

  void seed_around(std::uint32_t node) {
    add_seed(nodes_, node, seeds_);
    nodes_.graph.for_links(node, [&](std::uint32_t other, std::uint32_t) {
      if (nodes_.targets[other] != nodes_.targets[node]) add_seed(nodes_, other, seeds_);
    });
  }

  const TargetedGraph<Graph>& nodes_;
  const TaskRunner& runner_;
  SmoothingOptions options_;
  std::vector<std::int64_t> weights_;
  std::int64_t bound_;
  std::vector<std::uint32_t> slots_;
  Seeds seeds_;
};

template <class Graph>
void smooth_nodes(const TargetedGraph<Graph>& nodes, const TaskRunner& runner, const SmoothingOptions& options) {
  Smoothing<Graph> smoothing(nodes, runner, options);
  for (int i = 0; i < options.sweeps; ++i) smoothing.sweep();
}

}  // namespace

std::int64_t bound_of(std::span<const std::int64_t> weights, double imbalance) {
  const auto total = static_cast<double>(std::accumulate(weights.begin(), weights.end(), std::int64_t{0}));
  return static_cast<std::int64_t>(std::floor((1 + imbalance) * total / static_cast<double>(weights.size())));
}

void smooth_graph(const TargetedGraph<TetGraph>& nodes, const TaskRunner& runner, const SmoothingOptions& options) {
  smooth_nodes(nodes, runner, options);
}
void smooth_graph(const TargetedGraph<ClusterGraph>& nodes, const TaskRunner& runner, const SmoothingOptions& options) {
  smooth_nodes(nodes, runner, options);
}

void check_tets(const TargetedTets& tets, const TaskRunner* runner) {
  const std::size_t count = tets.targets.size();
  const auto bad = [] {
    throw Error(ErrorCode::InvalidArgument,
                "tets bound for targets need targets below the number of parts, positive weights and arrays that fit");
  };
  if (tets.neighbours.size() != 4 * count || (!tets.weights.empty() && tets.weights.size() != count)) bad();
  const auto check = [&](std::size_t begin, std::size_t end) {
    bool good = true;
    for (std::size_t i = begin; i < end; ++i) good &= tets.targets[i] < tets.part_count && weight_of(tets, i) > 0;
    if (!good) bad();
  };
  runner ? runner->for_blocks(count, kNodeGrain, check) : check(0, count);
}

std::vector<std::int64_t> weights_by_target(const TargetedTets& tets, const TaskRunner* runner) {
  return sum_by_target(tets.targets, tets.part_count, runner, [&](std::uint32_t tet) { return weight_of(tets, tet); });
}

}  // namespace balance_detail

void smooth_part_boundaries(const TargetedTets& tets, const TaskRunner& runner, const SmoothingOptions& options) {
  if (!(options.imbalance >= 0)) throw Error(ErrorCode::InvalidArgument, "a bound on imbalance is not negative");
  balance_detail::check_tets(tets, &runner);
  balance_detail::smooth_graph({balance_detail::TetGraph(tets), tets.targets, tets.part_count}, runner, options);
}

}  // namespace tetloom
