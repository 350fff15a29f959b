#include "threading/balance/pair_refinement_detail.hpp"

#include <algorithm>
#include <atomic>

#include "core/base/error.hpp"

namespace tetloom::balance_detail {

void GainQueues::reset(std::size_t count) {
  head_.fill(kNone);
  top_ = -kMaxGain;
  next_.resize(count);
  previous_.resize(count);
  queued_.assign(count, 0);
}

void GainQueues::push(std::uint32_t item, int gain) {
  std::uint32_t& head = head_[gain + kMaxGain];
  next_[item] = head;
  previous_[item] = kNone;
  if (head != kNone) previous_[head] = item;
  head = item;
  queued_[item] = 1;
  top_ = std::max(top_, gain);
}

void GainQueues::remove(std::uint32_t item, int gain) {
  if (previous_[item] == kNone)
    head_[gain + kMaxGain] = next_[item];
  else
    next_[previous_[item]] = next_[item];
  if (next_[item] != kNone) previous_[next_[item]] = previous_[item];
  queued_[item] = 0;
}

std::uint32_t GainQueues::top() {
  while (top_ > -kMaxGain && head_[top_ + kMaxGain] == kNone) --top_;
  return head_[top_ + kMaxGain];
}

PairRefinement::PairRefinement(const TargetedTets& tets, PartPair pair, std::array<std::int64_t, 2> weights,
                               std::int64_t bound, const SmoothingOptions& options)
    : tets_(tets), pair_(pair), weights_(weights), bound_(bound), options_(options) {}

int PairRefinement::side_of_tet(std::uint32_t tet) const {
  const std::uint32_t target = tets_.targets[tet];
  return target == pair_[0] ? 0 : target == pair_[1] ? 1 : -1;
}

bool PairRefinement::touches_other_side(std::uint32_t tet, int side) const {
  for (int face = 0; face < 4; ++face) {
    const std::uint32_t code = tets_.neighbours[4 * std::size_t{tet} + face];
    if (code != TargetedTets::kNoNeighbour && tets_.targets[code >> 2] == pair_[1 - side]) return true;
  }
  return false;
}

void PairRefinement::run(std::span<const std::uint32_t> seeds, std::span<std::uint32_t> slots) {
  gather(seeds, slots);
  link(slots);
  for (const std::uint32_t tet : band_) slots[tet] = GainQueues::kNone;
  for (int i = 0; i < options_.passes && pass(); ++i) {}
}

void PairRefinement::gather(std::span<const std::uint32_t> seeds, std::span<std::uint32_t> slots) {
  const auto add = [&](std::uint32_t tet) {
    slots[tet] = static_cast<std::uint32_t>(band_.size());
    band_.push_back(tet);
  };
  for (const std::uint32_t tet : seeds) {
    const int side = side_of_tet(tet);
    if (side >= 0 && slots[tet] == GainQueues::kNone && touches_other_side(tet, side)) add(tet);
  }
  boundary_count_ = band_.size();
  std::size_t begin = 0;
  for (int layer = 1; layer < options_.layers; ++layer) {
    const std::size_t end = band_.size();
    for (; begin < end; ++begin)
      for (int face = 0; face < 4; ++face) {
        const std::uint32_t code = tets_.neighbours[4 * std::size_t{band_[begin]} + face];
        if (code == TargetedTets::kNoNeighbour || side_of_tet(code >> 2) < 0) continue;
        if (slots[code >> 2] == GainQueues::kNone) add(code >> 2);
      }
  }
}

void PairRefinement::link(std::span<std::uint32_t> slots) {
  const std::size_t count = band_.size();
  neighbours_.resize(count);
  side_.resize(count);
  gain_.assign(count, 0);
  degree_.assign(count, 0);
  locked_.assign(count, 0);
  for (std::size_t i = 0; i < count; ++i) {
    side_[i] = static_cast<std::int8_t>(side_of_tet(band_[i]));
    for (int face = 0; face < 4; ++face) {
      neighbours_[i][face] = GainQueues::kNone;
      const std::uint32_t code = tets_.neighbours[4 * std::size_t{band_[i]} + face];
      const int side = code == TargetedTets::kNoNeighbour ? -1 : side_of_tet(code >> 2);
      if (side < 0) continue;
      neighbours_[i][face] = slots[code >> 2];
      ++degree_[i];
      gain_[i] = static_cast<std::int8_t>(gain_[i] + (side == side_[i] ? -1 : 1));
    }
  }
}

void PairRefinement::fill_queues() {
  for (GainQueues& queue : queues_) queue.reset(band_.size());
  std::fill(locked_.begin(), locked_.end(), 0);
  for (std::uint32_t i = 0; i < band_.size(); ++i)
    if (gain_[i] > -degree_[i]) queues_[side_[i]].push(i, gain_[i]);
}

bool PairRefinement::may_move(std::uint32_t item) const {
  const int from = side_[item];
  const std::int64_t weight = weight_of(tets_, band_[item]);
  return weight < weights_[from] && weights_[1 - from] + weight <= std::max(bound_, weights_[from] - 1);
}

std::uint32_t PairRefinement::pick() {
  const std::array<std::uint32_t, 2> best{queues_[0].top(), queues_[1].top()};
  const int heavier = weights_[1] > weights_[0] ? 1 : 0;
  int first = heavier;
  if (best[0] != GainQueues::kNone && best[1] != GainQueues::kNone && gain_[best[0]] != gain_[best[1]])
    first = gain_[best[0]] > gain_[best[1]] ? 0 : 1;
  for (const int side : {first, 1 - first})
    if (best[side] != GainQueues::kNone && may_move(best[side])) return best[side];
  return GainQueues::kNone;
}

bool PairRefinement::pass() {
  fill_queues();
  std::vector<std::uint32_t> moved;
  std::size_t kept = 0;
  int gained = 0, most = 0;
  const std::size_t patience = 50 + static_cast<std::size_t>(options_.patience * static_cast<double>(boundary_count_));
  for (std::uint32_t item; moved.size() - kept < patience && (item = pick()) != GainQueues::kNone;) {
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

void PairRefinement::move(std::uint32_t item, bool undo) {
  const int from = side_[item];
  if (!undo) {
    queues_[from].remove(item, gain_[item]);
    locked_[item] = 1;
  }
  const std::int64_t weight = weight_of(tets_, band_[item]);
  weights_[from] -= weight;
  weights_[1 - from] += weight;
  side_[item] = static_cast<std::int8_t>(1 - from);
  gain_[item] = static_cast<std::int8_t>(-gain_[item]);
  for (const std::uint32_t other : neighbours_[item])
    if (other != GainQueues::kNone) change_gain(other, side_[other] == from ? 2 : -2, undo);
}

void PairRefinement::change_gain(std::uint32_t item, int change, bool undo) {
  GainQueues& queue = queues_[side_[item]];
  const bool queue_it = !undo && !locked_[item];
  if (queue_it && queue.contains(item)) queue.remove(item, gain_[item]);
  gain_[item] = static_cast<std::int8_t>(gain_[item] + change);
  if (queue_it && gain_[item] > -degree_[item]) queue.push(item, gain_[item]);
}

std::vector<std::uint32_t> PairRefinement::apply() {
  std::vector<std::uint32_t> moved;
  for (std::size_t i = 0; i < band_.size(); ++i) {
    const std::uint32_t target = pair_[side_[i]];
    if (tets_.targets[band_[i]] == target) continue;
    tets_.targets[band_[i]] = target;
    moved.push_back(band_[i]);
  }
  return moved;
}

}  // namespace tetloom::balance_detail
