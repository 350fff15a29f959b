#include "core/part/adjacency.hpp"
#include "tetloom/partition.hpp"
#include "tetloom/tasks.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "threading/balance/graph_partitioners.hpp"
#include "threading/balance/multilevel.hpp"
#include "threading/balance/part_boundaries.hpp"
#include "threading/balance/partitioners.hpp"
#include "threading/balance/spread_graph_detail.hpp"
#include "threading/balance/stacks.hpp"
#include "threading/parts/idle_ranks.hpp"

namespace tetloom {
namespace {

// Weights of tets in the smoothing of boundaries, relative to the greatest one.
constexpr double kWeightUnits = 1 << 20;
// Below so many tets per target planes are as good and much faster.
constexpr std::size_t kTetsForLevels = 2000;

using balance_detail::StackItems;

// What the partitioners see of one part: cells, and stacks of cells.
struct PartItems {
  StackItems stacks;
  bool are_tets = false;  // all cells are tets, and each of them is an item
  std::vector<Point3f> points;
  std::vector<double> weights;
  double total = 0;
  Destinations targets;
};

std::vector<Point3f> compute_centroids(const PartMesh& part, const TaskRunner& runner) {
  std::vector<Point3f> points(part.cell_count());
  const CellNumbers numbers(part);
  for (const CellKind kind : kAllCellKinds) {
    const std::size_t begin = numbers.begin_of(kind), n = shape_of(kind).vertex_count;
    const double share = 1.0 / static_cast<double>(n);
    const std::uint32_t* verts = part.block(kind).to_vert.data();
    runner.for_blocks(part.block(kind).size(), std::size_t{1} << 16, [&](std::size_t first, std::size_t last) {
      for (std::size_t cell = first; cell < last; ++cell) {
        Vec3 sum{};
        for (std::size_t i = 0; i < n; ++i) sum = sum + part.points[verts[cell * n + i]];
        points[begin + cell] = {static_cast<float>(share * sum.x), static_cast<float>(share * sum.y),
                                static_cast<float>(share * sum.z)};
      }
    });
  }
  return points;
}

std::vector<double> read_weights(const PartMesh& part, const std::string& name) {
  std::vector<double> weights;
  const auto field = std::find_if(part.cell_fields.begin(), part.cell_fields.end(),
                                  [&](const CellField& candidate) { return candidate.name == name; });
  for (const auto& values : field->values) weights.insert(weights.end(), values.begin(), values.end());
  return weights;
}

// Whether parts can be cut on their own: they make a whole number of targets each, and are in balance.
bool can_split_locally(const PartitionedMesh& mesh, const BalanceOptions& options, const PerPart<PartItems>& items) {
  if (options.part_count % mesh.part_count() != 0) return false;
  double heaviest = 0;
  for (const PartId part : mesh.local()) heaviest = std::max(heaviest, items.at(part).total);
  // Weights are summed in units of 2^-20 of the greatest part's, so that the sum does not depend on ranks.
  std::array<double, 1> greatest{heaviest};
  mesh.communicator->max(greatest);
  std::int64_t total = 0;
  for (const PartId part : mesh.local()) total += std::llround(items.at(part).total / greatest[0] * kWeightUnits);
  std::array<std::int64_t, 1> sum{total};
  mesh.communicator->sum(sum);
  const double mean = static_cast<double>(sum[0]) / static_cast<double>(mesh.part_count());
  return kWeightUnits <= (1 + options.imbalance) * mean;
}

double greatest_of(std::span<const double> weights) {
  return weights.empty() ? 0 : *std::max_element(weights.begin(), weights.end());
}

std::vector<std::int64_t> integer_weights(std::span<const double> weights, double greatest) {
  std::vector<std::int64_t> result(weights.size());
  std::transform(weights.begin(), weights.end(), result.begin(), [&](double weight) {
    return std::max<std::int64_t>(1, std::llround(weight / greatest * kWeightUnits));
  });
  return result;
}

// Tets have codes tet · 4 + face in CellPlace, and the lack of a neighbour is the same there.
std::span<const std::uint32_t> neighbor_codes(const PartMesh& part) {
  const auto& places = part.block(CellKind::Tet).to_neighbor;
  static_assert(sizeof(CellPlace) == sizeof(std::uint32_t));
  return {reinterpret_cast<const std::uint32_t*>(places.data()), places.size()};
}

void smooth(const PartMesh& part, std::span<const double> weights, TargetRange range, double imbalance,
            Destinations& targets, const TaskRunner& runner) {
  for (std::uint32_t& target : targets) target -= range.first;
  const std::vector<std::int64_t> integers = integer_weights(weights, greatest_of(weights));
  SmoothingOptions options;
  options.imbalance = imbalance;
  smooth_part_boundaries({neighbor_codes(part), integers, targets, range.count}, runner, options);
  for (std::uint32_t& target : targets) target += range.first;
}

// The graph of items: a link stands for all faces between two of them.
struct ItemGraph {
  std::vector<std::uint64_t> first{0};
  std::vector<std::uint32_t> neighbours;
  std::vector<std::int64_t> links;
};

ItemGraph graph_of_items(const balance_detail::CellLinks<std::uint32_t>& cells, const StackItems& items) {
  std::vector<std::array<std::uint32_t, 2>> pairs;
  for (std::uint32_t cell = 0; cell + 1 < cells.first.size(); ++cell)
    for (std::uint64_t i = cells.first[cell]; i < cells.first[cell + 1]; ++i) {
      const std::uint32_t from = items.cell_to_item[cell], to = items.cell_to_item[cells.neighbours[i]];
      if (from != to) pairs.push_back({from, to});
    }
  std::ranges::sort(pairs);
  ItemGraph graph;
  for (std::size_t begin = 0, end = 0; begin < pairs.size(); begin = end) {
    while (end < pairs.size() && pairs[end] == pairs[begin]) ++end;
    graph.first.resize(pairs[begin][0] + std::size_t{1}, graph.neighbours.size());
    graph.neighbours.push_back(pairs[begin][1]);
    graph.links.push_back(static_cast<std::int64_t>(end - begin));
  }
  graph.first.resize(items.count + 1, graph.neighbours.size());
  return graph;
}

void split_by_scotch(const PartMesh& part, PartItems& items, TargetRange range, const BalanceOptions& options) {
  if (items.targets.empty()) return;
  balance_detail::CellLinks<std::uint32_t> links;
  links.add(part, CellNumbers(part));
  const std::vector<std::int64_t> integers = integer_weights(items.weights, greatest_of(items.weights));
  if (items.stacks.has_stacks()) {
    const ItemGraph graph = graph_of_items(links, items.stacks);
    partition_scotch({graph.first, graph.neighbours, integers, graph.links}, range.count, options.imbalance,
                     items.targets);
  } else {
    partition_scotch({links.first, links.neighbours, integers}, range.count, options.imbalance, items.targets);
  }
  for (std::uint32_t& target : items.targets) target += range.first;
}

ItemBlock block_of(const PartMesh& part, PartItems& items) {
  ItemBlock block;
  block.points = items.points;
  block.weights = items.weights;
  block.targets = items.targets;
  if (items.are_tets) block.neighbours = neighbor_codes(part);
  return block;
}

void split_by_planes(const PartMesh& part, PartItems& items, TargetRange range, const BalanceOptions& options,
                     const TaskRunner& runner) {
  const ItemBlock block = block_of(part, items);
  split_blocks_rcb({&block, 1}, {&range, 1}, runner);
  std::vector<Point3f>().swap(items.points);
  if (options.smooth && items.are_tets && range.count > 1)
    smooth(part, items.weights, range, options.imbalance, items.targets, runner);
}

bool is_in_balance(std::span<const double> weights, TargetRange range, double imbalance, const Destinations& targets) {
  std::vector<double> sums(range.count, 0);
  for (std::size_t i = 0; i < targets.size(); ++i) sums[targets[i]] += weights.empty() ? 1 : weights[i];
  const double mean = std::accumulate(sums.begin(), sums.end(), 0.0) / static_cast<double>(range.count);
  return *std::max_element(sums.begin(), sums.end()) <= (1 + imbalance) * mean * (1 + 1e-6);
}

/// Planes are taken instead where clusters do not pay, and where the graph did not lead to parts in balance.
void split_by_levels(const PartMesh& part, PartItems& items, TargetRange range, const BalanceOptions& options,
                     const TaskRunner& runner) {
  Destinations& targets = items.targets;
  if (items.are_tets && targets.size() >= kTetsForLevels * range.count) {
    const std::vector<std::int64_t> integers = integer_weights(items.weights, greatest_of(items.weights));
    partition_multilevel({neighbor_codes(part), integers, targets, range.count}, std::move(items.points), runner,
                         options.imbalance);
    if (is_in_balance(items.weights, range, options.imbalance, targets)) {
      for (std::uint32_t& target : targets) target += range.first;
      return;
    }
    items.points = compute_centroids(part, runner);
  }
  split_by_planes(part, items, range, options, runner);
}

// A stack lies at the mean of its cells and weighs as much as they do.
void join_stacks(PartItems& items) {
  const StackItems& stacks = items.stacks;
  std::vector<Vec3> sums(stacks.count);
  std::vector<double> weights(stacks.count, 0);
  for (std::size_t cell = 0; cell < stacks.cell_to_item.size(); ++cell) {
    const std::uint32_t item = stacks.cell_to_item[cell];
    const double weight = items.weights.empty() ? 1 : items.weights[cell];
    const Point3f& x = items.points[cell];
    sums[item] = sums[item] + weight * Vec3{x.x, x.y, x.z};
    weights[item] += weight;
  }
  items.points.resize(stacks.count);
  for (std::size_t i = 0; i < stacks.count; ++i) {
    const Vec3 x = (1 / weights[i]) * sums[i];
    items.points[i] = {static_cast<float>(x.x), static_cast<float>(x.y), static_cast<float>(x.z)};
  }
  items.weights = std::move(weights);
}

PartItems make_items(const PartMesh& part, const BalanceOptions& options, const TaskRunner& runner) {
  PartItems items;
  items.stacks = balance_detail::find_stack_items(part);
  items.are_tets = part.block(CellKind::Tet).size() == part.cell_count() && !items.stacks.has_stacks();
  items.points = compute_centroids(part, runner);
  if (!options.weights.empty()) items.weights = read_weights(part, options.weights);
  items.total = items.weights.empty() ? static_cast<double>(items.points.size())
                                      : std::accumulate(items.weights.begin(), items.weights.end(), 0.0);
  if (items.stacks.has_stacks()) join_stacks(items);
  items.targets.resize(items.points.size());
  return items;
}

class Dealer {
 public:
  Dealer(const PartitionedMesh& mesh, const BalanceOptions& options, const TaskRunner& runner)
      : mesh_(mesh), options_(options), runner_(runner), items_(mesh.part_count(), mesh.local()) {}

  PerPart<Destinations> run() {
    const auto local = mesh_.local();
    runner_.for_each(local.size(), [&](std::size_t i) {
      items_.at(local[i]) = make_items(mesh_.parts.at(local[i]).mesh, options_, runner_);
    });
    PerPart<Destinations> destinations(mesh_.part_count(), local);
    const bool split = can_split_locally(mesh_, options_, items_);
    if (options_.method == PartitionMethod::Scotch && !split) {
      deal_spread_graph(destinations);
    } else {
      split ? split_parts() : deal_anew();
      for (const PartId part : local)
        destinations.at(part) =
            balance_detail::destinations_of_cells(items_.at(part).stacks, std::move(items_.at(part).targets));
    }
    PerPart<StackItems> stacks(mesh_.part_count(), local);
    for (const PartId part : local) stacks.at(part) = std::move(items_.at(part).stacks);
    balance_detail::unite_stacks(mesh_, stacks, destinations);
    return destinations;
  }

 private:
  void split_parts() {
    const auto local = mesh_.local();
    const auto factor = static_cast<std::uint32_t>(options_.part_count / mesh_.part_count());
    const auto range_of = [&](PartId part) { return TargetRange{part.value * factor, factor}; };
    if (options_.method == PartitionMethod::Sfc) {
      std::vector<TargetRange> ranges;
      for (const PartId part : local) ranges.push_back(range_of(part));
      return split_blocks_sfc(blocks(), ranges, runner_);
    }
    runner_.for_each(local.size(), [&](std::size_t i) {
      const PartMesh& part = mesh_.parts.at(local[i]).mesh;
      PartItems& items = items_.at(local[i]);
      const TargetRange range = range_of(local[i]);
      switch (options_.method) {
        case PartitionMethod::Scotch: return split_by_scotch(part, items, range, options_);
        case PartitionMethod::Rcb: return split_by_planes(part, items, range, options_, runner_);
        default: return split_by_levels(part, items, range, options_, runner_);
      }
    });
  }

  void deal_anew() {
    const auto parts = static_cast<std::uint32_t>(options_.part_count);
    options_.method == PartitionMethod::Sfc ? partition_sfc(blocks(), parts, *mesh_.communicator, runner_)
                                            : partition_rcb(blocks(), parts, *mesh_.communicator, runner_);
  }

  // By cells: stacks are put together afterwards.
  void deal_spread_graph(PerPart<Destinations>& destinations) {
    PerPart<std::vector<std::int64_t>> weights(mesh_.part_count(), mesh_.local());
    if (!options_.weights.empty()) {
      PerPart<std::vector<double>> given(mesh_.part_count(), mesh_.local());
      std::array<double, 1> greatest{};
      for (const PartId part : mesh_.local()) {
        given.at(part) = read_weights(mesh_.parts.at(part).mesh, options_.weights);
        greatest[0] = std::max(greatest[0], greatest_of(given.at(part)));
      }
      mesh_.communicator->max(greatest);
      for (const PartId part : mesh_.local()) weights.at(part) = integer_weights(given.at(part), greatest[0]);
    }
    for (const PartId part : mesh_.local()) destinations.at(part).resize(mesh_.parts.at(part).mesh.cell_count());
    balance_detail::partition_spread_graph(mesh_, weights, static_cast<std::uint32_t>(options_.part_count),
                                           options_.imbalance, destinations, runner_);
  }

  std::vector<ItemBlock> blocks() {
    std::vector<ItemBlock> blocks;
    for (const PartId part : mesh_.local()) blocks.push_back(block_of(mesh_.parts.at(part).mesh, items_.at(part)));
    return blocks;
  }

  const PartitionedMesh& mesh_;
  const BalanceOptions& options_;
  const TaskRunner& runner_;
  PerPart<PartItems> items_;
};

}  // namespace

std::string_view to_string(PartitionMethod method) {
  switch (method) {
    case PartitionMethod::Multilevel: return "multilevel";
    case PartitionMethod::Rcb: return "rcb";
    case PartitionMethod::Sfc: return "sfc";
    default: return "scotch";
  }
}

PerPart<Destinations> compute_destinations(const PartitionedMesh& mesh, const BalanceOptions& options,
                                           const TaskRunner& given) {
  if (options.part_count == 0) throw Error(ErrorCode::InvalidArgument, "a mesh has at least one part");
  require_weights(mesh, options.weights);
  return Dealer(mesh, options, runner_for_cells(mesh, given)).run();
}

void deal_cells(PartitionedMesh& mesh, const BalanceOptions& options, const TaskRunner& runner) {
  PerPart<Destinations> destinations = compute_destinations(mesh, options, runner);
  migrate(mesh, std::move(destinations), options.part_count, runner);
}

}  // namespace tetloom
