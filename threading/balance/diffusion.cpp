#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>

#include "threading/balance/pair_refinement_detail.hpp"

namespace tetloom {

namespace balance_detail {

namespace {

/// The boundaries, ascending, each with the tets on either side that lie at it.
using Boundaries = std::map<PartPair, std::array<std::vector<std::uint32_t>, 2>>;

Boundaries find_boundaries(const TargetedTets& tets) {
  Boundaries boundaries;
  for (std::uint32_t tet = 0; tet < tets.targets.size(); ++tet)
    for (int face = 0; face < 4; ++face) {
      const std::uint32_t own = tets.targets[tet], code = tets.neighbours[4 * std::size_t{tet} + face];
      if (code == TargetedTets::kNoNeighbour || tets.targets[code >> 2] == own) continue;
      const std::uint32_t other = tets.targets[code >> 2];
      auto& list = boundaries[{std::min(own, other), std::max(own, other)}][own < other ? 0 : 1];
      if (list.empty() || list.back() != tet) list.push_back(tet);
    }
  return boundaries;
}

/// Solves L·potential = surplus by conjugate gradients, L the Laplacian of the graph of parts. The surplus must sum to
/// zero in each connected piece; where it does not, the result is as near as iterations bring it.
std::vector<double> find_potential(std::span<const PartPair> edges, std::span<const double> surplus) {
  const std::size_t n = surplus.size();
  std::vector<double> potential(n, 0), residual(surplus.begin(), surplus.end()), direction = residual, image(n);
  const auto product = [](const auto& a, const auto& b) {
    return std::inner_product(a.begin(), a.end(), b.begin(), 0.0);
  };
  double norm = product(residual, residual);
  const double enough = 1e-12 * norm;
  for (std::size_t i = 0; i < 4 * n && norm > enough; ++i) {
    std::fill(image.begin(), image.end(), 0.0);
    for (const auto& [a, b] : edges) {
      image[a] += direction[a] - direction[b];
      image[b] += direction[b] - direction[a];
    }
    const double curvature = product(direction, image);
    if (!(curvature > 0)) break;
    const double step = norm / curvature;
    for (std::size_t p = 0; p < n; ++p) {
      potential[p] += step * direction[p];
      residual[p] -= step * image[p];
    }
    const double before = norm;
    norm = product(residual, residual);
    for (std::size_t p = 0; p < n; ++p) direction[p] = residual[p] + norm / before * direction[p];
  }
  return potential;
}

int gain_of(const TargetedTets& tets, std::uint32_t tet, std::uint32_t to) {
  int gain = 0;
  for (int face = 0; face < 4; ++face) {
    const std::uint32_t code = tets.neighbours[4 * std::size_t{tet} + face];
    if (code == TargetedTets::kNoNeighbour) continue;
    if (tets.targets[code >> 2] == to) ++gain;
    if (tets.targets[code >> 2] == tets.targets[tet]) --gain;
  }
  return gain;
}

/// Moves tets from one target to another across their boundary, those of the greatest gain first and of these the
/// oldest, until `amount` has moved as nearly as whole tets allow. Returns how much has.
std::int64_t push_across(const TargetedTets& tets, std::uint32_t from, std::uint32_t to, std::int64_t amount,
                         std::span<const std::uint32_t> seeds) {
  std::array<std::vector<std::uint32_t>, 9> queues;
  const auto queue_of = [&](int gain) -> auto& { return queues[static_cast<std::size_t>(4 - gain)]; };
  for (const std::uint32_t tet : seeds) queue_of(gain_of(tets, tet, to)).push_back(tet);
  std::array<std::size_t, 9> head{};
  std::int64_t moved = 0;
  for (std::size_t q = 0; q < queues.size();) {
    if (head[q] == queues[q].size()) {
      ++q;
      continue;
    }
    const std::uint32_t tet = queues[q][head[q]++];
    // Each change of a gain queues the tet again; only the entry that is still true counts.
    if (tets.targets[tet] != from || 4 - gain_of(tets, tet, to) != static_cast<int>(q)) continue;
    const std::int64_t weight = weight_of(tets, tet);
    if (2 * (amount - moved) < weight) break;
    tets.targets[tet] = to;
    moved += weight;
    for (int face = 0; face < 4; ++face) {
      const std::uint32_t code = tets.neighbours[4 * std::size_t{tet} + face];
      if (code == TargetedTets::kNoNeighbour || tets.targets[code >> 2] != from) continue;
      const int gain = gain_of(tets, code >> 2, to);
      queue_of(gain).push_back(code >> 2);
      q = std::min(q, static_cast<std::size_t>(4 - gain));
    }
  }
  return moved;
}

}  // namespace
}  // namespace balance_detail

std::int64_t diffuse_load(const TargetedTets& tets) {
  using namespace balance_detail;
  check_tets(tets, nullptr);
  std::vector<std::int64_t> weights = weights_by_target(tets, nullptr);
  const Boundaries boundaries = find_boundaries(tets);
  std::vector<PartPair> edges;
  for (const auto& [pair, lists] : boundaries) edges.push_back(pair);
  const std::int64_t total = std::accumulate(weights.begin(), weights.end(), std::int64_t{0});
  std::vector<double> surplus(weights.size());
  for (std::size_t p = 0; p < surplus.size(); ++p)
    surplus[p] = static_cast<double>(weights[p]) - static_cast<double>(total) / static_cast<double>(weights.size());
  const std::vector<double> potential = find_potential(edges, surplus);
  std::int64_t moved = 0;
  for (const auto& [pair, lists] : boundaries) {
    const double flow = potential[pair[0]] - potential[pair[1]];
    const int side = flow > 0 ? 0 : 1;
    const std::uint32_t from = pair[side], to = pair[1 - side];
    const std::int64_t amount = std::min(std::llround(std::abs(flow)), static_cast<long long>(weights[from] - 1));
    const std::int64_t crossed = push_across(tets, from, to, amount, lists[side]);
    weights[from] -= crossed;
    weights[to] += crossed;
    moved += crossed;
  }
  return moved;
}

}  // namespace tetloom
