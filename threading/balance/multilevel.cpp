#include "threading/balance/multilevel.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "tetloom/error.hpp"
#include "tetloom/tasks.hpp"
#include "threading/balance/aggregation_detail.hpp"
#include "threading/balance/graph_partitioners.hpp"
#include "threading/balance/pair_refinement_detail.hpp"

namespace tetloom {

namespace balance_detail {

namespace {

constexpr std::size_t kClustersPerPart = 1500, kLeastClusters = 16000, kMostClusters = 50000;
constexpr std::size_t kLeastClustersPerPart = 40;
constexpr std::size_t kTetsPerCluster = 20, kClustersPerCluster = 10;
constexpr SmoothingOptions kCoarse{.layers = 3, .sweeps = 2, .passes = 4, .patience = 0.1};
constexpr SmoothingOptions kFine{};
constexpr int kRepairs = 3;

/// Clusters of one level, and which cluster of the next one each belongs to.
struct Level {
  ClusterGraph graph;
  std::vector<std::uint32_t> cluster_of;
};

class Multilevel {
 public:
  Multilevel(const TargetedTets& tets, const TaskRunner& runner, double imbalance)
      : tets_(tets), graph_(tets), runner_(runner), imbalance_(imbalance) {
    const auto weights = weights_by_target(tets, &runner);
    total_ = std::accumulate(weights.begin(), weights.end(), std::int64_t{0});
    wanted_ = std::max(std::clamp(kClustersPerPart * tets.part_count, kLeastClusters, kMostClusters),
                       kLeastClustersPerPart * tets.part_count);
  }

  void run(std::vector<Point3f> points) {
    coarsen(std::move(points));
    cut();
    while (!levels_.empty()) refine_level();
    smooth();
    repair();
  }

 private:
  void coarsen(std::vector<Point3f> points) {
    Chunks chunks = find_chunks(std::move(points), tets_.targets, runner_);
    Chunks clusters = aggregate(graph_, chunks, size_for(graph_.size(), kTetsPerCluster), tets_.targets, runner_);
    levels_.push_back({contract(graph_, chunks, clusters, tets_.targets, runner_), {}});
    bool shrinks = true;
    while (shrinks && levels_.back().graph.size() > wanted_ + wanted_ / 2) {
      Level& level = levels_.back();
      chunks = std::move(clusters);
      level.cluster_of.resize(level.graph.size());
      clusters =
          aggregate(level.graph, chunks, size_for(level.graph.size(), kClustersPerCluster), level.cluster_of, runner_);
      ClusterGraph coarse = contract(level.graph, chunks, clusters, level.cluster_of, runner_);
      shrinks = coarse.size() < level.graph.size() - level.graph.size() / 10;
      levels_.push_back({std::move(coarse), {}});
    }
  }

  /// Clusters as large as they may be: the finest levels cost the most.
  ClusterSize size_for(std::size_t nodes, std::size_t most) const {
    const auto count = static_cast<std::uint32_t>(std::clamp<std::size_t>((nodes + wanted_ / 2) / wanted_, 1, most));
    const auto clusters = static_cast<std::int64_t>(nodes / count + 1);
    return {count, std::max<std::int64_t>(1, 2 * (total_ / clusters))};
  }

  void cut() {
    const ClusterGraph& graph = levels_.back().graph;
    targets_.resize(graph.size());
    const std::vector<std::int64_t> links(graph.links.begin(), graph.links.end());
    partition_scotch({graph.first, graph.neighbours, graph.weights, links}, tets_.part_count, imbalance_ / 2, targets_);
  }

  /// Refines the coarsest level, and carries its targets over to the next finer one.
  void refine_level() {
    SmoothingOptions options = kCoarse;
    options.imbalance = imbalance_;
    smooth_graph({levels_.back().graph, targets_, tets_.part_count}, runner_, options);
    levels_.pop_back();
    if (levels_.empty()) {
      project(tets_.targets, tets_.targets);
      std::vector<std::uint32_t>().swap(targets_);
    } else {
      std::vector<std::uint32_t> finer(levels_.back().graph.size());
      project(levels_.back().cluster_of, finer);
      targets_ = std::move(finer);
    }
  }

  void project(std::span<const std::uint32_t> cluster_of, std::span<std::uint32_t> finer) const {
    runner_.for_blocks(finer.size(), kNodeGrain, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) finer[i] = targets_[cluster_of[i]];
    });
  }

  void smooth() {
    SmoothingOptions options = kFine;
    options.imbalance = imbalance_;
    smooth_graph({graph_, tets_.targets, tets_.part_count}, runner_, options);
  }

  void repair() {
    for (int i = 0; i < kRepairs; ++i) {
      const auto weights = weights_by_target(tets_, &runner_);
      if (std::ranges::max(weights) <= bound_of(weights, imbalance_)) return;
      diffuse_load(tets_);
      smooth();
    }
  }

  const TargetedTets& tets_;
  TetGraph graph_;
  const TaskRunner& runner_;
  double imbalance_;
  std::int64_t total_ = 0;
  std::size_t wanted_ = 0;  // clusters on the coarsest level
  std::vector<Level> levels_;
  std::vector<std::uint32_t> targets_;  // on the coarsest level that is left
};

void check_points(std::span<const Point3f> points, std::size_t tets, const TaskRunner& runner) {
  const auto bad = [] {
    throw Error(ErrorCode::InvalidArgument, "tets to be dealt to parts need one finite place each");
  };
  if (points.size() != tets) bad();
  runner.for_blocks(points.size(), kNodeGrain, [&](std::size_t begin, std::size_t end) {
    bool finite = true;
    for (std::size_t i = begin; i < end; ++i)
      finite &= std::isfinite(points[i].x) && std::isfinite(points[i].y) && std::isfinite(points[i].z);
    if (!finite) bad();
  });
}

}  // namespace
}  // namespace balance_detail

void partition_multilevel(const TargetedTets& tets, std::vector<Point3f> points, const TaskRunner& runner,
                          double imbalance) {
  if (tets.part_count == 0 || !(imbalance >= 0))
    throw Error(ErrorCode::InvalidArgument, "there must be parts, and a bound on imbalance that is not negative");
  std::ranges::fill(tets.targets, 0U);
  balance_detail::check_tets(tets, &runner);
  balance_detail::check_points(points, tets.targets.size(), runner);
  if (tets.part_count == 1 || tets.targets.empty()) return;
  balance_detail::Multilevel(tets, runner, imbalance).run(std::move(points));
}

}  // namespace tetloom
