#pragma once
// Zoltan, for graphs of cells that are spread over MPI ranks. Built with TETLOOM_MPI.
#include <cstdint>
#include <span>

namespace tetloom {

/// The cells of all parts of this rank. Cells have numbers 0, 1, … over all ranks; those of a rank follow one another,
/// and lower ranks have lower numbers.
struct DistributedCells {
  std::uint64_t first_cell = 0;                ///< the number of this rank's first one
  std::span<const std::uint64_t> first;        ///< cells of this rank + 1 offsets into `neighbours`
  std::span<const std::uint64_t> neighbours;   ///< by number; symmetric over all ranks, without loops
  std::span<const std::int64_t> weights = {};  ///< positive, one per cell; empty on every rank: 1 each
};

/// Cuts the graph into `part_count` parts with few edges between them through Zoltan's parallel hypergraph package.
/// All ranks of `mpi_communicator` (the number that MPI_Comm_c2f gives; MPI is initialised) call it together, one
/// thread each: Zoltan is not thread-safe. Unlike the partitioners of this library the result depends on the number of
/// ranks and on how cells lie on them; with these fixed it is the same each time.
///
/// Errors: InvalidArgument on every rank where one rank's arrays do not fit; Internal where Zoltan fails, which may
/// also print to stderr. Global numbers are passed as two 32-bit words, since Debian's Zoltan has 32-bit ones.
void partition_zoltan(const DistributedCells& cells, std::uint32_t part_count, double imbalance,
                      std::span<std::uint32_t> targets, int mpi_communicator);

}  // namespace tetloom
