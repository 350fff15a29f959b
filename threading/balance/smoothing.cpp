#include <algorithm>
#include <atomic>
#include <cmath>
#include <map>
#include <optional>

#include "core/base/error.hpp"
#include "threading/balance/pair_refinement_detail.hpp"

namespace tetloom {

namespace balance_detail {

namespace {

constexpr std::size_t kGrain = std::size_t{1} << 16;

using Seeds = std::map<PartPair, std::vector<std::uint32_t>>;

PartPair ordered(std::uint32_t a, std::uint32_t b) { return a < b ? PartPair{a, b} : PartPair{b, a}; }

/// Adds a tet to the seeds of each boundary that it lies at.
void add_seed(const TargetedTets& tets, std::uint32_t tet, Seeds& seeds) {
  const std::uint32_t own = tets.targets[tet];
  for (int face = 0; face < 4; ++face) {
    const std::uint32_t code = tets.neighbours[4 * std::size_t{tet} + face];
    if (code == TargetedTets::kNoNeighbour || tets.targets[code >> 2] == own) continue;
    auto& list = seeds[ordered(own, tets.targets[code >> 2])];
    if (list.empty() || list.back() != tet) list.push_back(tet);
  }
}

Seeds find_seeds(const TargetedTets& tets, const TaskRunner& runner) {
  std::vector<Seeds> by_block((tets.targets.size() + kGrain - 1) / kGrain);
  runner.for_blocks(tets.targets.size(), kGrain, [&](std::size_t begin, std::size_t end) {
    for (std::size_t tet = begin; tet < end; ++tet)
      add_seed(tets, static_cast<std::uint32_t>(tet), by_block[begin / kGrain]);
  });
  Seeds seeds;
  for (Seeds& block : by_block)
    for (auto& [pair, list] : block) {
      auto& all = seeds[pair];
      all.insert(all.end(), list.begin(), list.end());
    }
  return seeds;
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

class Smoothing {
 public:
  Smoothing(const TargetedTets& tets, const TaskRunner& runner, const SmoothingOptions& options)
      : tets_(tets), runner_(runner), options_(options), weights_(weights_by_target(tets, &runner)) {
    std::int64_t total = 0;
    for (const std::int64_t w : weights_) total += w;
    bound_ = static_cast<std::int64_t>(
        std::floor((1 + options.imbalance) * static_cast<double>(total) / static_cast<double>(tets.part_count)));
    slots_.resize(tets.targets.size());
    runner.for_blocks(slots_.size(), kGrain, [&](std::size_t begin, std::size_t end) {
      std::fill(slots_.begin() + begin, slots_.begin() + end, GainQueues::kNone);
    });
    seeds_ = find_seeds(tets, runner);
  }

  void sweep() {
    std::vector<PartPair> waiting;
    for (const auto& [pair, list] : seeds_) waiting.push_back(pair);
    std::stable_sort(waiting.begin(), waiting.end(),
                     [&](const PartPair& a, const PartPair& b) { return seeds_[a].size() > seeds_[b].size(); });
    while (!waiting.empty()) refine(take_independent(waiting, tets_.part_count));
  }

 private:
  void refine(std::span<const PartPair> pairs) {
    std::vector<std::optional<PairRefinement>> work(pairs.size());
    std::vector<std::vector<std::uint32_t>> moved(pairs.size());
    runner_.for_each(pairs.size(), [&](std::size_t i) {
      const auto [a, b] = pairs[i];
      work[i].emplace(tets_, pairs[i], std::array{weights_[a], weights_[b]}, bound_, options_);
      work[i]->run(seeds_.at(pairs[i]), slots_);
    });
    // Targets are written only here: while bands are gathered, a band reads the targets of tets of other pairs.
    runner_.for_each(pairs.size(), [&](std::size_t i) { moved[i] = work[i]->apply(); });
    for (std::size_t i = 0; i < pairs.size(); ++i) {
      for (int side = 0; side < 2; ++side) weights_[pairs[i][side]] = work[i]->weights()[side];
      for (const std::uint32_t tet : moved[i]) seed_around(tet);
    }
  }

  void seed_around(std::uint32_t tet) {
    add_seed(tets_, tet, seeds_);
    for (int face = 0; face < 4; ++face) {
      const std::uint32_t code = tets_.neighbours[4 * std::size_t{tet} + face];
      if (code != TargetedTets::kNoNeighbour && tets_.targets[code >> 2] != tets_.targets[tet])
        add_seed(tets_, code >> 2, seeds_);
    }
  }

  const TargetedTets& tets_;
  const TaskRunner& runner_;
  SmoothingOptions options_;
  std::vector<std::int64_t> weights_;
  std::int64_t bound_ = 0;
  std::vector<std::uint32_t> slots_;
  Seeds seeds_;
};

}  // namespace

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
  runner ? runner->for_blocks(count, kGrain, check) : check(0, count);
}

std::vector<std::int64_t> weights_by_target(const TargetedTets& tets, const TaskRunner* runner) {
  const std::size_t count = tets.targets.size();
  const std::size_t lanes = runner ? static_cast<std::size_t>(runner->threads()) : 1;
  std::vector<std::vector<std::int64_t>> sums(lanes, std::vector<std::int64_t>(tets.part_count, 0));
  const auto add = [&](std::size_t lane) {
    for (std::size_t i = lane * count / lanes; i < (lane + 1) * count / lanes; ++i)
      sums[lane][tets.targets[i]] += weight_of(tets, i);
  };
  runner ? runner->for_each(lanes, add) : add(0);
  for (std::size_t lane = 1; lane < lanes; ++lane)
    for (std::size_t p = 0; p < tets.part_count; ++p) sums[0][p] += sums[lane][p];
  return std::move(sums[0]);
}

}  // namespace balance_detail

void smooth_part_boundaries(const TargetedTets& tets, const TaskRunner& runner, const SmoothingOptions& options) {
  if (!(options.imbalance >= 0)) throw Error(ErrorCode::InvalidArgument, "a bound on imbalance is not negative");
  balance_detail::check_tets(tets, &runner);
  balance_detail::Smoothing smoothing(tets, runner, options);
  for (int i = 0; i < options.sweeps; ++i) smoothing.sweep();
}

}  // namespace tetloom
