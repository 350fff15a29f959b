#pragma once
// Graphs that the boundaries between targets are refined on: tets linked by faces, and clusters of tets.
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "tetloom/tasks.hpp"
#include "threading/balance/part_boundaries.hpp"

namespace tetloom::balance_detail {

constexpr std::uint32_t kNoNode = 0xffffffff;
constexpr std::size_t kNodeGrain = std::size_t{1} << 16;

/// The tets of a block: a link of 1 for each face between two of them.
struct TetGraph {
  std::span<const std::uint32_t> neighbours;  ///< as in TargetedTets
  std::span<const std::int64_t> tet_weights;  ///< empty: 1 each

  explicit TetGraph(const TargetedTets& tets) : neighbours(tets.neighbours), tet_weights(tets.weights) {}
  std::size_t size() const { return neighbours.size() / 4; }
  std::int64_t weight(std::uint32_t tet) const { return tet_weights.empty() ? 1 : tet_weights[tet]; }
  /// visit(neighbour, link) for each neighbour.
  template <class Visit>
  void for_links(std::uint32_t tet, const Visit& visit) const {
    for (std::size_t face = 4 * std::size_t{tet}; face < 4 * std::size_t{tet} + 4; ++face)
      if (neighbours[face] != TargetedTets::kNoNeighbour) visit(neighbours[face] >> 2, 1U);
  }
};

/// Clusters of tets: a link is the number of faces between two of them. Symmetric, without loops.
struct ClusterGraph {
  std::vector<std::uint64_t> first{0};  ///< clusters + 1 offsets
  std::vector<std::uint32_t> neighbours, links;
  std::vector<std::int64_t> weights;

  std::size_t size() const { return weights.size(); }
  std::int64_t weight(std::uint32_t cluster) const { return weights[cluster]; }
  template <class Visit>
  void for_links(std::uint32_t cluster, const Visit& visit) const {
    for (std::uint64_t i = first[cluster]; i < first[cluster + 1]; ++i) visit(neighbours[i], links[i]);
  }
};

/// A graph and where each of its nodes is bound for.
template <class Graph>
struct TargetedGraph {
  const Graph& graph;
  std::span<std::uint32_t> targets;
  std::uint32_t part_count = 1;
};

/// The greatest weight that a target may have: (1 + imbalance) times the mean.
std::int64_t bound_of(std::span<const std::int64_t> weights, double imbalance);

/// What smooth_part_boundaries does, for either kind of graph. Pre: targets below the number of parts.
void smooth_graph(const TargetedGraph<TetGraph>& nodes, const TaskRunner& runner, const SmoothingOptions& options);
void smooth_graph(const TargetedGraph<ClusterGraph>& nodes, const TaskRunner& runner, const SmoothingOptions& options);

}  // namespace tetloom::balance_detail
