#include "threading/balance/pair_refinement_detail.hpp"

#include <algorithm>

namespace tetloom::balance_detail {

void GainQueues::reset(std::size_t count, int greatest) {
  greatest_ = greatest;
  top_ = -greatest;
  head_.assign(2 * static_cast<std::size_t>(greatest) + 1, kNoNode);
  next_.resize(count);
  previous_.resize(count);
  queued_.assign(count, 0);
}

void GainQueues::push(std::uint32_t item, int gain) {
  std::uint32_t& first = head(gain);
  next_[item] = first;
  previous_[item] = kNoNode;
  if (first != kNoNode) previous_[first] = item;
  first = item;
  queued_[item] = 1;
  top_ = std::max(top_, gain);
}

void GainQueues::remove(std::uint32_t item, int gain) {
  if (previous_[item] == kNoNode)
    head(gain) = next_[item];
  else
    next_[previous_[item]] = next_[item];
  if (next_[item] != kNoNode) previous_[next_[item]] = previous_[item];
  queued_[item] = 0;
}

std::uint32_t GainQueues::top() {
  while (top_ > -greatest_ && head(top_) == kNoNode) --top_;
  return head(top_);
}

template <class Graph>
PairRefinement<Graph>::PairRefinement(const TargetedGraph<Graph>& nodes, PartPair pair,
                                      std::array<std::int64_t, 2> weights, std::int64_t bound,
                                      const SmoothingOptions& options)
    : nodes_(nodes), pair_(pair), weights_(weights), bound_(bound), options_(options) {}

template <class Graph>
int PairRefinement<Graph>::side_of_node(std::uint32_t node) const {
  const std::uint32_t target = nodes_.targets[node];
  return target == pair_[0] ? 0 : target == pair_[1] ? 1 : -1;
}

template <class Graph>
bool PairRefinement<Graph>::touches_other_side(std::uint32_t node, int side) const {
  bool touches = false;
  nodes_.graph.for_links(
      node, [&](std::uint32_t other, std::uint32_t) { touches |= nodes_.targets[other] == pair_[1 - side]; });
  return touches;
}

template <class Graph>
void PairRefinement<Graph>::run(std::span<const std::uint32_t> seeds, std::span<std::uint32_t> slots) {
  gather(seeds, slots);
  link(slots);
  for (const std::uint32_t node : band_) slots[node] = kNoNode;
  for (int i = 0; i < options_.passes && pass(); ++i) {}
}

template <class Graph>
void PairRefinement<Graph>::gather(std::span<const std::uint32_t> seeds, std::span<std::uint32_t> slots) {
  const auto add = [&](std::uint32_t node) {
    slots[node] = static_cast<std::uint32_t>(band_.size());
    band_.push_back(node);
  };
  for (const std::uint32_t node : seeds) {
    const int side = side_of_node(node);
    if (side >= 0 && slots[node] == kNoNode && touches_other_side(node, side)) add(node);
  }
  boundary_count_ = band_.size();
  std::size_t begin = 0;
  for (int layer = 1; layer < options_.layers; ++layer) {
    const std::size_t end = band_.size();
    for (; begin < end; ++begin)
      nodes_.graph.for_links(band_[begin], [&](std::uint32_t other, std::uint32_t) {
        if (side_of_node(other) >= 0 && slots[other] == kNoNode) add(other);
      });
  }
}

template <class Graph>
void PairRefinement<Graph>::link(std::span<const std::uint32_t> slots) {
  const std::size_t count = band_.size();
  first_.assign(1, 0);
  side_.resize(count);
  gain_.assign(count, 0);
  degree_.assign(count, 0);
  locked_.assign(count, 0);
  lightest_ = count == 0 ? 0 : nodes_.graph.weight(band_[0]);
  for (std::size_t i = 0; i < count; ++i) {
    side_[i] = static_cast<std::int8_t>(side_of_node(band_[i]));
    lightest_ = std::min(lightest_, nodes_.graph.weight(band_[i]));
    nodes_.graph.for_links(band_[i], [&](std::uint32_t other, std::uint32_t faces) {
      const int side = side_of_node(other), links = static_cast<int>(faces);
      if (side < 0) return;
      if (slots[other] != kNoNode) links_.push_back({slots[other], links});
      degree_[i] += links;
      gain_[i] += side == side_[i] ? -links : links;
    });
    first_.push_back(static_cast<std::uint32_t>(links_.size()));
  }
}

template <class Graph>
void PairRefinement<Graph>::fill_queues() {
  const int greatest = band_.empty() ? 0 : *std::max_element(degree_.begin(), degree_.end());
  for (GainQueues& queue : queues_) queue.reset(band_.size(), greatest);
  std::fill(locked_.begin(), locked_.end(), 0);
  for (std::uint32_t i = 0; i < band_.size(); ++i)
    if (gain_[i] > -degree_[i]) queues_[side_[i]].push(i, gain_[i]);
}

template <class Graph>
bool PairRefinement<Graph>::may_leave(int side, std::int64_t weight) const {
  return weight < weights_[side] && weights_[1 - side] + weight <= std::max(bound_, weights_[side] - 1);
}

template <class Graph>
std::uint32_t PairRefinement<Graph>::top_that_may_move(int side) {
  for (;;) {
    const std::uint32_t item = queues_[side].top();
    if (item == kNoNode || may_leave(side, nodes_.graph.weight(band_[item]))) return item;
    if (!may_leave(side, lightest_)) return kNoNode;
    queues_[side].remove(item, gain_[item]);
  }
}

template <class Graph>
std::uint32_t PairRefinement<Graph>::pick() {
  const std::array<std::uint32_t, 2> best{top_that_may_move(0), top_that_may_move(1)};
  if (best[0] == kNoNode || best[1] == kNoNode) return best[0] == kNoNode ? best[1] : best[0];
  if (gain_[best[0]] != gain_[best[1]]) return gain_[best[0]] > gain_[best[1]] ? best[0] : best[1];
  return best[weights_[1] > weights_[0] ? 1 : 0];
}

template <class Graph>
bool PairRefinement<Graph>::pass() {
  fill_queues();
  std::vector<std::uint32_t> moved;
  std::size_t kept = 0;
  std::int64_t gained = 0, most = 0;
  const std::size_t patience = 50 + static_cast<std::size_t>(options_.patience * static_cast<double>(boundary_count_));
  for (std::uint32_t item; moved.size() - kept < patience && (item = pick()) != kNoNode;) {
    gained += gain_[item];
    move(item, false);
    moved.push_back(item);
    if (gained > most) {
      most = gained;
      kept = moved.size();
    }
  }
  for (; moved.size() > kept; moved.pop_back()) move(moved.back(), true);
  return most > 0;
}

template <class Graph>
void PairRefinement<Graph>::move(std::uint32_t item, bool undo) {
  const int from = side_[item];
  if (!undo) {
    queues_[from].remove(item, gain_[item]);
    locked_[item] = 1;
  }
  const std::int64_t weight = nodes_.graph.weight(band_[item]);
  weights_[from] -= weight;
  weights_[1 - from] += weight;
  side_[item] = static_cast<std::int8_t>(1 - from);
  gain_[item] = -gain_[item];
  for (std::uint32_t i = first_[item]; i < first_[item + 1]; ++i) {
    const auto [other, links] = links_[i];
    change_gain(other, side_[other] == from ? 2 * links : -2 * links, undo);
  }
}

template <class Graph>
void PairRefinement<Graph>::change_gain(std::uint32_t item, int change, bool undo) {
  GainQueues& queue = queues_[side_[item]];
  const bool queue_it = !undo && !locked_[item];
  if (queue_it && queue.contains(item)) queue.remove(item, gain_[item]);
  gain_[item] += change;
  if (queue_it && gain_[item] > -degree_[item]) queue.push(item, gain_[item]);
}

template <class Graph>
std::vector<std::uint32_t> PairRefinement<Graph>::apply() {
  std::vector<std::uint32_t> moved;
  for (std::size_t i = 0; i < band_.size(); ++i) {
    const std::uint32_t target = pair_[side_[i]];
    if (nodes_.targets[band_[i]] == target) continue;
    nodes_.targets[band_[i]] = target;
    moved.push_back(band_[i]);
  }
  return moved;
}

template class PairRefinement<TetGraph>;
template class PairRefinement<ClusterGraph>;

}  // namespace tetloom::balance_detail
