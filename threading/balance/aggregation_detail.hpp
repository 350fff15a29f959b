#pragma once
// Clusters of tets that lie together, and the graph between them.
#include <cstdint>
#include <span>
#include <vector>

#include "tetloom/tasks.hpp"
#include "threading/balance/graph_detail.hpp"
#include "threading/balance/partitioners.hpp"

namespace tetloom::balance_detail {

/// The nodes of a graph by chunks, which are worked on independently: those of chunk c are at begin[c] … begin[c+1].
struct Chunks {
  std::vector<std::uint32_t> begin{0};
  std::vector<std::uint32_t> nodes;  ///< empty: each node is at its own number

  std::size_t count() const { return begin.size() - 1; }
  std::uint32_t node(std::uint32_t at) const { return nodes.empty() ? at : nodes[at]; }
};

/// Sorts items into chunks of about 2^15 or more, at most 256, by a tree of planes through the medians of a sample. How
/// many there are depends on the number of items alone. The points are freed before the result is made. `chunk_of`:
/// scratch, one per point.
Chunks find_chunks(std::vector<Point3f> points, std::span<std::uint32_t> chunk_of, const TaskRunner& runner);

/// How large clusters become.
struct ClusterSize {
  std::uint32_t nodes = 12;  ///< about this many
  std::int64_t weight = 0;   ///< at most, unless a single node is heavier
};

/// Joins the nodes of each chunk in clusters: each grows by the node that it shares the most faces with, and starts
/// next to one that is finished; what is left over in fragments goes to its neighbours. Writes the cluster of each node
/// and returns the chunks of the clusters, whose numbers ascend by chunk. On graphs of clusters nodes then move once to
/// the cluster that they share the most faces with, which makes them compact. O(links); chunks in parallel; the result
/// depends on the graph and the chunks alone.
Chunks aggregate(const TetGraph& graph, const Chunks& chunks, ClusterSize size, std::span<std::uint32_t> cluster_of,
                 const TaskRunner& runner);
Chunks aggregate(const ClusterGraph& graph, const Chunks& chunks, ClusterSize size, std::span<std::uint32_t> cluster_of,
                 const TaskRunner& runner);

/// The graph between clusters. `chunks`: of the nodes, `clusters`: as `aggregate` returned them.
ClusterGraph contract(const TetGraph& graph, const Chunks& chunks, const Chunks& clusters,
                      std::span<const std::uint32_t> cluster_of, const TaskRunner& runner);
ClusterGraph contract(const ClusterGraph& graph, const Chunks& chunks, const Chunks& clusters,
                      std::span<const std::uint32_t> cluster_of, const TaskRunner& runner);

}  // namespace tetloom::balance_detail
