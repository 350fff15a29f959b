#include <algorithm>
#include <array>
#include <atomic>
#include <type_traits>

#include "tetloom/tasks.hpp"
#include "threading/balance/aggregation_detail.hpp"

namespace tetloom::balance_detail {

namespace {

constexpr std::uint32_t kFree = std::uint32_t{1} << 31;  // and the chunk

struct LinkedNode {
  std::uint32_t node, links;
};

void add_links(std::vector<LinkedNode>& list, std::uint32_t node, std::uint32_t links) {
  for (LinkedNode& known : list)
    if (known.node == node) {
      known.links += links;
      return;
    }
  list.push_back({node, links});
}

std::vector<LinkedNode>::iterator find_most_linked(std::vector<LinkedNode>& list) {
  return std::max_element(list.begin(), list.end(),
                          [](const LinkedNode& a, const LinkedNode& b) { return a.links < b.links; });
}

/// The nodes next to a growing cluster; `pop` takes the one with the most links to it, and of these the oldest.
class LinkedFront {
 public:
  void clear() { list_.clear(); }
  template <class CountLinks>
  void add(std::uint32_t node, std::uint32_t links, const CountLinks&) {
    add_links(list_, node, links);
  }
  std::uint32_t pop() {
    if (list_.empty()) return kNoNode;
    const auto best = find_most_linked(list_);
    const std::uint32_t node = best->node;
    list_.erase(best);
    return node;
  }

 private:
  std::vector<LinkedNode> list_;
};

/// The same for tets, where links are few: it may give a node twice.
class TetFront {
 public:
  void clear() {
    for (auto& list : lists_) list.clear();
    next_ = 0;
  }
  /// `count_links(tet)`: its links to the cluster.
  template <class CountLinks>
  void add(std::uint32_t tet, std::uint32_t, const CountLinks& count_links) {
    lists_[count_links(tet) > 1 ? 1 : 0].push_back(tet);
  }
  std::uint32_t pop() {
    if (!lists_[1].empty()) {
      const std::uint32_t tet = lists_[1].back();
      lists_[1].pop_back();
      return tet;
    }
    return next_ < lists_[0].size() ? lists_[0][next_++] : kNoNode;
  }

 private:
  std::array<std::vector<std::uint32_t>, 2> lists_;  // with one link and with more
  std::size_t next_ = 0;
};

template <class Graph>
using Front = std::conditional_t<std::is_same_v<Graph, TetGraph>, TetFront, LinkedFront>;

/// The clusters of one chunk. Until all chunks are done they are numbered from the place of the chunk's first node, so
/// that a number tells whether the cluster is of this chunk.
template <class Graph>
class ChunkAggregation {
 public:
  ChunkAggregation(const Graph& graph, const Chunks& chunks, std::uint32_t chunk, ClusterSize size,
                   std::span<std::uint32_t> cluster_of)
      : graph_(graph),
        chunks_(chunks),
        begin_(chunks.begin[chunk]),
        end_(chunks.begin[chunk + 1]),
        free_(kFree | chunk),
        size_(size),
        cluster_of_(cluster_of) {}

  std::uint32_t run() {
    for (std::uint32_t at = begin_; at < end_; ++at) {
      grow_from(chunks_.node(at));
      // Next to what is done, so that no gaps are left.
      for (std::size_t next = 0; next < seeds_.size(); ++next) grow_from(seeds_[next]);
      seeds_.clear();
    }
    if (std::is_same_v<Graph, ClusterGraph>) tidy();
    return count_;
  }

 private:
  // Other chunks write their own nodes' values meanwhile (`set`); none of these looks like a free node of this chunk
  // or like one of its clusters.
  std::uint32_t get(std::uint32_t node) const {
    return std::atomic_ref(cluster_of_[node]).load(std::memory_order_relaxed);
  }
  void set(std::uint32_t node, std::uint32_t cluster) {
    std::atomic_ref(cluster_of_[node]).store(cluster, std::memory_order_relaxed);
  }
  bool is_own(std::uint32_t cluster) const { return cluster - begin_ < count_; }

  void grow_from(std::uint32_t seed) {
    if (get(seed) != free_) return;
    members_.clear();
    front_.clear();
    weight_ = 0;
    std::uint32_t node = seed;
    for (; node != kNoNode && members_.size() < size_.nodes; node = front_.pop()) {
      if (get(node) != free_) continue;
      if (node != seed && weight_ + graph_.weight(node) > size_.weight)
        seeds_.push_back(node);
      else
        take(node);
    }
    for (; node != kNoNode; node = front_.pop()) seeds_.push_back(node);
    if (3 * members_.size() >= size_.nodes || !join_neighbour()) ++count_;
  }

  void take(std::uint32_t node) {
    const std::uint32_t cluster = begin_ + count_;
    set(node, cluster);
    members_.push_back(node);
    weight_ += graph_.weight(node);
    const auto count_links = [&](std::uint32_t candidate) {
      std::uint32_t count = 0;
      graph_.for_links(candidate, [&](std::uint32_t other, std::uint32_t) { count += get(other) == cluster ? 1 : 0; });
      return count;
    };
    graph_.for_links(node, [&](std::uint32_t other, std::uint32_t links) {
      if (get(other) == free_) front_.add(other, links, count_links);
    });
  }

  /// A fragment goes to the cluster of this chunk that it shares the most faces with, if there is one.
  bool join_neighbour() {
    around_.clear();
    for (const std::uint32_t node : members_)
      graph_.for_links(node, [&](std::uint32_t other, std::uint32_t links) {
        const std::uint32_t cluster = get(other);
        if (is_own(cluster)) add_links(around_, cluster, links);
      });
    if (around_.empty()) return false;
    const std::uint32_t cluster = find_most_linked(around_)->node;
    for (const std::uint32_t node : members_) set(node, cluster);
    return true;
  }

  /// Nodes go to the cluster that they share the most faces with.
  void tidy() {
    std::vector<std::int64_t> weights(count_, 0);
    for (std::uint32_t at = begin_; at < end_; ++at)
      weights[get(chunks_.node(at)) - begin_] += graph_.weight(chunks_.node(at));
    for (std::uint32_t at = begin_; at < end_; ++at) {
      const std::uint32_t node = chunks_.node(at), own = get(node);
      const std::uint32_t best = find_better(node, own);
      if (best == kNoNode) continue;
      const std::int64_t weight = graph_.weight(node);
      // A cluster must not lose its last node.
      if (weights[own - begin_] == weight || weights[best - begin_] + weight > size_.weight) continue;
      weights[own - begin_] -= weight;
      weights[best - begin_] += weight;
      set(node, best);
    }
  }

  std::uint32_t find_better(std::uint32_t node, std::uint32_t own) {
    std::uint32_t own_links = 0;
    around_.clear();
    graph_.for_links(node, [&](std::uint32_t other, std::uint32_t links) {
      const std::uint32_t cluster = get(other);
      if (cluster == own)
        own_links += links;
      else if (is_own(cluster))
        add_links(around_, cluster, links);
    });
    if (around_.empty()) return kNoNode;
    const LinkedNode best = *find_most_linked(around_);
    return best.links > own_links ? best.node : kNoNode;
  }

  const Graph& graph_;
  const Chunks& chunks_;
  std::uint32_t begin_, end_, free_;
  ClusterSize size_;
  std::span<std::uint32_t> cluster_of_;
  std::uint32_t count_ = 0;
  std::int64_t weight_ = 0;  // of the growing cluster
  std::vector<std::uint32_t> members_, seeds_;
  Front<Graph> front_;
  std::vector<LinkedNode> around_;
};

template <class Graph>
Chunks aggregate_graph(const Graph& graph, const Chunks& chunks, ClusterSize size, std::span<std::uint32_t> cluster_of,
                       const TaskRunner& runner) {
  const auto for_nodes = [&](std::size_t chunk, const auto& body) {
    for (std::uint32_t at = chunks.begin[chunk]; at < chunks.begin[chunk + 1]; ++at) body(chunks.node(at));
  };
  runner.for_each(chunks.count(), [&](std::size_t chunk) {
    for_nodes(chunk, [&](std::uint32_t node) { cluster_of[node] = kFree | static_cast<std::uint32_t>(chunk); });
  });
  std::vector<std::uint32_t> counts(chunks.count());
  runner.for_each(chunks.count(), [&](std::size_t chunk) {
    counts[chunk] = ChunkAggregation<Graph>(graph, chunks, static_cast<std::uint32_t>(chunk), size, cluster_of).run();
  });
  Chunks clusters;
  for (const std::uint32_t count : counts) clusters.begin.push_back(clusters.begin.back() + count);
  runner.for_each(chunks.count(), [&](std::size_t chunk) {
    const std::uint32_t shift = chunks.begin[chunk] - clusters.begin[chunk];
    for_nodes(chunk, [&](std::uint32_t node) { cluster_of[node] -= shift; });
  });
  return clusters;
}

/// The links of one chunk's clusters.
struct ChunkLinks {
  std::vector<std::uint32_t> neighbours, links;
};

template <class Graph>
class ChunkContraction {
 public:
  ChunkContraction(const Graph& graph, const Chunks& chunks, const Chunks& clusters,
                   std::span<const std::uint32_t> cluster_of, std::size_t chunk)
      : graph_(graph), cluster_of_(cluster_of), first_(clusters.begin[chunk]), last_(clusters.begin[chunk + 1]) {
    sort_members(chunks, chunk);
  }

  /// Writes weights and degrees into the graph of clusters.
  ChunkLinks run(ClusterGraph& coarse) {
    ChunkLinks result;
    result.neighbours.reserve(12 * std::size_t{last_ - first_});
    result.links.reserve(12 * std::size_t{last_ - first_});
    std::vector<std::uint64_t> found;  // neighbour · 2^32 + links
    for (std::uint32_t cluster = first_; cluster < last_; ++cluster) {
      found.clear();
      std::int64_t weight = 0;
      for (std::uint32_t i = begin_[cluster - first_]; i < begin_[cluster - first_ + 1]; ++i) {
        weight += graph_.weight(members_[i]);
        graph_.for_links(members_[i], [&](std::uint32_t other, std::uint32_t links) {
          if (cluster_of_[other] != cluster) add(found, cluster_of_[other], links);
        });
      }
      for (const std::uint64_t link : found) {
        result.neighbours.push_back(static_cast<std::uint32_t>(link >> 32));
        result.links.push_back(static_cast<std::uint32_t>(link));
      }
      coarse.weights[cluster] = weight;
      coarse.first[cluster + 1] = found.size();
    }
    return result;
  }

 private:
  static void add(std::vector<std::uint64_t>& found, std::uint32_t cluster, std::uint32_t links) {
    for (std::uint64_t& known : found)
      if (known >> 32 == cluster) {
        known += links;
        return;
      }
    found.push_back(std::uint64_t{cluster} << 32 | links);
  }

  void sort_members(const Chunks& chunks, std::size_t chunk) {
    const std::uint32_t begin = chunks.begin[chunk], end = chunks.begin[chunk + 1];
    begin_.assign(last_ - first_ + 2, 0);
    for (std::uint32_t at = begin; at < end; ++at) ++begin_[cluster_of_[chunks.node(at)] - first_ + 2];
    for (std::size_t i = 1; i < begin_.size(); ++i) begin_[i] += begin_[i - 1];
    members_.resize(end - begin);
    for (std::uint32_t at = begin; at < end; ++at) {
      const std::uint32_t node = chunks.node(at);
      members_[begin_[cluster_of_[node] - first_ + 1]++] = node;
    }
  }

  const Graph& graph_;
  std::span<const std::uint32_t> cluster_of_;
  std::uint32_t first_, last_;
  std::vector<std::uint32_t> begin_, members_;
};

template <class Graph>
ClusterGraph contract_graph(const Graph& graph, const Chunks& chunks, const Chunks& clusters,
                            std::span<const std::uint32_t> cluster_of, const TaskRunner& runner) {
  ClusterGraph coarse;
  coarse.weights.resize(clusters.begin.back());
  coarse.first.resize(coarse.weights.size() + 1);
  std::vector<ChunkLinks> links(chunks.count());
  runner.for_each(chunks.count(), [&](std::size_t chunk) {
    links[chunk] = ChunkContraction<Graph>(graph, chunks, clusters, cluster_of, chunk).run(coarse);
  });
  for (std::size_t i = 1; i < coarse.first.size(); ++i) coarse.first[i] += coarse.first[i - 1];
  coarse.neighbours.resize(coarse.first.back());
  coarse.links.resize(coarse.first.back());
  runner.for_each(chunks.count(), [&](std::size_t chunk) {
    const auto at = static_cast<std::ptrdiff_t>(coarse.first[clusters.begin[chunk]]);
    std::copy(links[chunk].neighbours.begin(), links[chunk].neighbours.end(), coarse.neighbours.begin() + at);
    std::copy(links[chunk].links.begin(), links[chunk].links.end(), coarse.links.begin() + at);
    links[chunk] = {};
  });
  return coarse;
}

}  // namespace

Chunks aggregate(const TetGraph& graph, const Chunks& chunks, ClusterSize size, std::span<std::uint32_t> cluster_of,
                 const TaskRunner& runner) {
  return aggregate_graph(graph, chunks, size, cluster_of, runner);
}
Chunks aggregate(const ClusterGraph& graph, const Chunks& chunks, ClusterSize size, std::span<std::uint32_t> cluster_of,
                 const TaskRunner& runner) {
  return aggregate_graph(graph, chunks, size, cluster_of, runner);
}
ClusterGraph contract(const TetGraph& graph, const Chunks& chunks, const Chunks& clusters,
                      std::span<const std::uint32_t> cluster_of, const TaskRunner& runner) {
  return contract_graph(graph, chunks, clusters, cluster_of, runner);
}
ClusterGraph contract(const ClusterGraph& graph, const Chunks& chunks, const Chunks& clusters,
                      std::span<const std::uint32_t> cluster_of, const TaskRunner& runner) {
  return contract_graph(graph, chunks, clusters, cluster_of, runner);
}

}  // namespace tetloom::balance_detail
