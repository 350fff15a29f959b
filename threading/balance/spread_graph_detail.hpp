#pragma once
// Graph partitioning of cells that lie in several parts.
#include <cstdint>
#include <span>
#include <vector>

#include "threading/migration.hpp"

namespace tetloom::balance_detail {

/// Cuts the graph of all cells of all parts anew, by Scotch where there is one rank and by Zoltan where there are more.
/// `weights` are positive, one per cell, or empty in all parts. A collective call; the whole graph stands in memory,
/// some 60 bytes per tet. The result depends on the number of ranks as well where there are several.
void partition_spread_graph(const PartitionedMesh& mesh, const PerPart<std::vector<std::int64_t>>& weights,
                            std::uint32_t part_count, double imbalance, PerPart<Destinations>& destinations,
                            const TaskRunner& runner);

}  // namespace tetloom::balance_detail
