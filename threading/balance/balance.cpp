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
#include "threading/parts/idle_ranks.hpp"

namespace tetloom {
namespace {

// Weights of tets in the smoothing of boundaries, relative to the greatest one.
constexpr double kWeightUnits = 1 << 20;
// Below so many tets per target planes are as good and much faster.
constexpr std::size_t kTetsForLevels = 2000;

// What the partitioners see of one part.
struct PartItems {
  std::vector<Point3f> points;
  std::vector<double> weights;
  double total = 0;
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

bool has_tets_alone(const PartMesh& part) { return part.block(CellKind::Tet).size() == part.cell_count(); }

void smooth(const PartMesh& part, std::span<const double> weights, TargetRange range, double imbalance,
            Destinations& targets, const TaskRunner& runner) {
  if (range.count == 1 || !has_tets_alone(part)) return;
  for (std::uint32_t& target : targets) target -= range.first;
  const std::vector<std::int64_t> integers = integer_weights(weights, greatest_of(weights));
  SmoothingOptions options;
  options.imbalance = imbalance;
  smooth_part_boundaries({neighbor_codes(part), integers, targets, range.count}, runner, options);
  for (std::uint32_t& target : targets) target += range.first;
}

void partition_by_scotch(const PartMesh& part, std::span<const double> weights, TargetRange range, double imbalance,
                         Destinations& targets) {
  balance_detail::CellLinks<std::uint32_t> links;
  links.add(part, CellNumbers(part));
  const std::vector<std::int64_t> integers = integer_weights(weights, greatest_of(weights));
  partition_scotch({links.first, links.neighbours, integers}, range.count, imbalance, targets);
  for (std::uint32_t& target : targets) target += range.first;
}

ItemBlock block_of(const PartMesh& part, const PartItems& items, Destinations& targets) {
  ItemBlock block;
  block.points = items.points;
  block.weights = items.weights;
  block.targets = targets;
  if (has_tets_alone(part)) block.neighbours = neighbor_codes(part);
  return block;
}

void split_by_planes(const PartMesh& part, PartItems& items, TargetRange range, const BalanceOptions& options,
                     Destinations& targets, const TaskRunner& runner) {
  const ItemBlock block = block_of(part, items, targets);
  split_blocks_rcb({&block, 1}, {&range, 1}, runner);
  std::vector<Point3f>().swap(items.points);
  if (options.smooth) smooth(part, items.weights, range, options.imbalance, targets, runner);
}

bool is_in_balance(std::span<const double> weights, TargetRange range, double imbalance, const Destinations& targets) {
  std::vector<double> sums(range.count, 0);
  for (std::size_t i = 0; i < targets.size(); ++i) sums[targets[i]] += weights.empty() ? 1 : weights[i];
  const double mean = std::accumulate(sums.begin(), sums.end(), 0.0) / static_cast<double>(range.count);
  return *std::max_element(sums.begin(), sums.end()) <= (1 + imbalance) * mean * (1 + 1e-6);
}

/// Planes are taken instead where clusters do not pay, and where the graph did not lead to parts in balance.
void split_by_levels(const PartMesh& part, PartItems& items, TargetRange range, const BalanceOptions& options,
                     Destinations& targets, const TaskRunner& runner) {
  if (has_tets_alone(part) && targets.size() >= kTetsForLevels * range.count) {
    const std::vector<std::int64_t> integers = integer_weights(items.weights, greatest_of(items.weights));
    partition_multilevel({neighbor_codes(part), integers, targets, range.count}, std::move(items.points), runner,
                         options.imbalance);
    if (is_in_balance(items.weights, range, options.imbalance, targets)) {
      for (std::uint32_t& target : targets) target += range.first;
      return;
    }
    items.points = compute_centroids(part, runner);
  }
  split_by_planes(part, items, range, options, targets, runner);
}

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
  const TaskRunner runner = runner_for_cells(mesh, given);
  const auto local = mesh.local();
  PerPart<PartItems> items(mesh.part_count(), local);
  PerPart<Destinations> destinations(mesh.part_count(), local);
  runner.for_each(local.size(), [&](std::size_t i) {
    const PartMesh& part = mesh.parts.at(local[i]).mesh;
    PartItems& own = items.at(local[i]);
    own.points = compute_centroids(part, runner);
    if (!options.weights.empty()) own.weights = read_weights(part, options.weights);
    own.total = own.weights.empty() ? static_cast<double>(own.points.size())
                                    : std::accumulate(own.weights.begin(), own.weights.end(), 0.0);
    destinations.at(local[i]).resize(own.points.size());
  });

  const bool split = can_split_locally(mesh, options, items);
  const auto factor = static_cast<std::uint32_t>(split ? options.part_count / mesh.part_count() : options.part_count);
  std::vector<ItemBlock> blocks;
  std::vector<TargetRange> ranges;
  for (const PartId part : local) {
    blocks.push_back(block_of(mesh.parts.at(part).mesh, items.at(part), destinations.at(part)));
    ranges.push_back({split ? part.value * factor : 0, factor});
  }
  const auto part_count = static_cast<std::uint32_t>(options.part_count);
  if (options.method == PartitionMethod::Scotch && split) {
    runner.for_each(local.size(), [&](std::size_t i) {
      if (items.at(local[i]).points.empty()) return;
      partition_by_scotch(mesh.parts.at(local[i]).mesh, items.at(local[i]).weights, ranges[i], options.imbalance,
                          destinations.at(local[i]));
    });
  } else if (options.method == PartitionMethod::Scotch) {
    PerPart<std::vector<std::int64_t>> weights(mesh.part_count(), local);
    std::array<double, 1> greatest{};
    for (const PartId part : local) greatest[0] = std::max(greatest[0], greatest_of(items.at(part).weights));
    mesh.communicator->max(greatest);
    for (const PartId part : local) weights.at(part) = integer_weights(items.at(part).weights, greatest[0]);
    balance_detail::partition_spread_graph(mesh, weights, part_count, options.imbalance, destinations, runner);
  } else if (options.method == PartitionMethod::Sfc) {
    split ? split_blocks_sfc(blocks, ranges, runner) : partition_sfc(blocks, part_count, *mesh.communicator, runner);
  } else if (split) {
    const auto split_part = options.method == PartitionMethod::Rcb ? split_by_planes : split_by_levels;
    runner.for_each(local.size(), [&](std::size_t i) {
      split_part(mesh.parts.at(local[i]).mesh, items.at(local[i]), ranges[i], options, destinations.at(local[i]),
                 runner);
    });
  } else {
    partition_rcb(blocks, part_count, *mesh.communicator, runner);
  }
  return destinations;
}

void deal_cells(PartitionedMesh& mesh, const BalanceOptions& options, const TaskRunner& runner) {
  PerPart<Destinations> destinations = compute_destinations(mesh, options, runner);
  migrate(mesh, std::move(destinations), options.part_count, runner);
}

}  // namespace tetloom
