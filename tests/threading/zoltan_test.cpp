// Run by mpirun on two ranks: each has half of the cells of a ball. Plain checks, since Catch2 knows no ranks.
#include <mpi.h>

#include <algorithm>
#include <cstdio>
#include <vector>

#include "tests/support/tet_lattice.hpp"
#include "tetloom/error.hpp"
#include "threading/balance/partition_figures.hpp"
#include "threading/balance/zoltan_partitioner.hpp"

using namespace tetloom;

namespace {

/// The targets of all cells, on every rank.
std::vector<std::uint32_t> partition(const test::TetLattice& lattice, std::uint32_t parts, int rank, int ranks) {
  const std::size_t count = lattice.centroids.size(), begin = rank * count / ranks, end = (rank + 1) * count / ranks;
  std::vector<std::uint64_t> first{0}, neighbours;
  for (std::size_t tet = begin; tet < end; ++tet) {
    for (std::size_t face = 0; face < 4; ++face)
      if (const std::uint32_t code = lattice.neighbours[4 * tet + face]; code != TargetedTets::kNoNeighbour)
        neighbours.push_back(code / 4);
    first.push_back(neighbours.size());
  }
  std::vector<std::uint32_t> own(end - begin), all(count, 0);
  partition_zoltan({begin, first, neighbours}, parts, 0.03, own, MPI_Comm_c2f(MPI_COMM_WORLD));
  std::copy(own.begin(), own.end(), all.begin() + begin);
  MPI_Allreduce(MPI_IN_PLACE, all.data(), static_cast<int>(count), MPI_UINT32_T, MPI_MAX, MPI_COMM_WORLD);
  return all;
}

bool run(int rank, int ranks) {
  const test::TetLattice lattice = test::make_tet_lattice(20, test::in_ball);
  auto targets = partition(lattice, 6, rank, ranks);
  const PartitionFigures figures = measure_partition({lattice.neighbours, {}, targets, 6});
  bool refused = false;
  try {
    std::vector<std::uint32_t> none;
    const std::vector<std::uint64_t> empty{0};
    partition_zoltan({0, rank == 0 ? std::span<const std::uint64_t>{} : empty, {}}, 6, 0.03, none,
                     MPI_Comm_c2f(MPI_COMM_WORLD));
  } catch (const Error& error) {
    refused = error.code() == ErrorCode::InvalidArgument;
  }
  const bool good = refused && targets == partition(lattice, 6, rank, ranks) && figures.element_imbalance < 0.05 &&
                    figures.cut_faces > 0 && figures.cut_faces < 4000;
  if (!good || rank == 0)
    std::printf("rank %d: refused %d, imbalance %.3f, cut faces %lld\n", rank, refused, figures.element_imbalance,
                static_cast<long long>(figures.cut_faces));
  return good;
}

}  // namespace

int main(int argc, char** argv) {
  MPI_Init(&argc, &argv);
  int rank = 0, ranks = 1;
  MPI_Comm_rank(MPI_COMM_WORLD, &rank);
  MPI_Comm_size(MPI_COMM_WORLD, &ranks);
  int bad = run(rank, ranks) ? 0 : 1;
  MPI_Allreduce(MPI_IN_PLACE, &bad, 1, MPI_INT, MPI_MAX, MPI_COMM_WORLD);
  MPI_Finalize();
  return bad;
}
