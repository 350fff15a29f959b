#pragma once
// Partitioners of others for graphs of cells: Scotch in this process.
#include <cstdint>
#include <span>

namespace tetloom {

/// Cells and what they share faces with. Symmetric, without loops.
struct CellGraph {
  std::span<const std::uint64_t> first;       ///< cells + 1 offsets into `neighbours`
  std::span<const std::uint32_t> neighbours;  ///< cells
  std::span<const std::int64_t> weights;      ///< positive, one per cell; empty: 1 each
  std::span<const std::int64_t> links = {};   ///< positive, how many faces each neighbour stands for; empty: 1 each
};

/// Cuts a graph into `part_count` parts with few edges between them, none heavier than (1 + imbalance) of the mean as
/// far as Scotch manages. Serial; any number of calls may run at the same time; the result depends on the arguments
/// and on Scotch's version. Weights are scaled down where their sum is beyond Scotch's integers.
///
/// Errors: InvalidArgument for arrays that do not fit or graphs too large for Scotch's integers; OutOfMemory;
/// Internal with Scotch's own words where it fails. Scotch prints nothing: this library defines the two functions
/// through which it reports (SCOTCH_errorPrint, SCOTCH_errorPrintW), so none of its error libraries is linked.
void partition_scotch(const CellGraph& graph, std::uint32_t part_count, double imbalance,
                      std::span<std::uint32_t> targets);

}  // namespace tetloom
