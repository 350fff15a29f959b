#pragma once
// Where the cells of a partitioned mesh should go.
#include <cstddef>
#include <string>
#include <string_view>

#include "threading/migration.hpp"

namespace tetloom {

enum class PartitionMethod {
  Multilevel,  ///< by the graph of tets, through clusters (multilevel.hpp), where a part of tets is cut on its own;
               ///< otherwise, and for small parts, as Rcb
  Rcb,         ///< recursive bisection by planes; part boundaries are smoothed then
  Sfc,         ///< along a Hilbert curve
  Scotch       ///< graph partitioning: by Scotch, or by Zoltan where parts that are dealt anew lie on several ranks
};

std::string_view to_string(PartitionMethod method);

struct BalanceOptions {
  std::size_t part_count = 1;
  PartitionMethod method = PartitionMethod::Multilevel;
  std::string weights;      ///< a cell field of one positive component; empty: 1 for each cell
  double imbalance = 0.03;  ///< how much heavier than the mean a part may become for a smaller boundary
  bool smooth = true;       ///< smooth part boundaries after Rcb
};

/// The destinations for `migrate`. Where the number of parts grows by a whole factor and the parts are in balance, each
/// part is cut on its own, and its pieces get neighbouring numbers; otherwise all cells are dealt anew.
///
/// A collective call. The result depends on the parts and the options only. Boundaries are smoothed where all cells of
/// a target lie in one part, and all cells are tets.
/// Errors: InvalidArgument (no part, a field that is not there or has values that are not positive), OutOfMemory,
/// Cancelled.
PerPart<Destinations> compute_destinations(const PartitionedMesh& mesh, const BalanceOptions& options,
                                           const TaskRunner& runner);

/// Computes the destinations and moves the cells there. A collective call; errors are those of both.
void deal_cells(PartitionedMesh& mesh, const BalanceOptions& options, const TaskRunner& runner);

}  // namespace tetloom
