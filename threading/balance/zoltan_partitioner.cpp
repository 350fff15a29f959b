#include "threading/balance/zoltan_partitioner.hpp"

#include <mpi.h>
#include <zoltan.h>

#include <algorithm>
#include <array>
#include <limits>
#include <string>
#include <vector>

#include "tetloom/error.hpp"

namespace tetloom {

namespace {

/// What Zoltan's callbacks are given.
struct Query {
  const DistributedCells* cells = nullptr;
  std::vector<std::uint64_t> first_of_rank;

  std::size_t count() const { return cells->first.size() - 1; }
  int rank_of(std::uint64_t cell) const {
    const auto after = std::upper_bound(first_of_rank.begin(), first_of_rank.end(), cell);
    return static_cast<int>(after - first_of_rank.begin()) - 1;
  }
};

const Query& query_of(void* data) { return *static_cast<const Query*>(data); }

void write_number(std::uint64_t number, ZOLTAN_ID_PTR words) {
  words[0] = static_cast<ZOLTAN_ID_TYPE>(number >> 32);
  words[1] = static_cast<ZOLTAN_ID_TYPE>(number & 0xffffffffU);
}

int count_objects(void* data, int* status) {
  *status = ZOLTAN_OK;
  return static_cast<int>(query_of(data).count());
}

void list_objects(void* data, int, int, ZOLTAN_ID_PTR numbers, ZOLTAN_ID_PTR indices, int weights, float* weight,
                  int* status) {
  const DistributedCells& cells = *query_of(data).cells;
  for (std::size_t i = 0; i < query_of(data).count(); ++i) {
    write_number(cells.first_cell + i, numbers + 2 * i);
    indices[i] = static_cast<ZOLTAN_ID_TYPE>(i);
    if (weights > 0) weight[i] = cells.weights.empty() ? 1.0F : static_cast<float>(cells.weights[i]);
  }
  *status = ZOLTAN_OK;
}

void count_edges(void* data, int, int, int objects, ZOLTAN_ID_PTR, ZOLTAN_ID_PTR indices, int* counts, int* status) {
  const DistributedCells& cells = *query_of(data).cells;
  for (int i = 0; i < objects; ++i) counts[i] = static_cast<int>(cells.first[indices[i] + 1] - cells.first[indices[i]]);
  *status = ZOLTAN_OK;
}

void list_edges(void* data, int, int, int objects, ZOLTAN_ID_PTR, ZOLTAN_ID_PTR indices, int*, ZOLTAN_ID_PTR numbers,
                int* ranks, int weights, float* weight, int* status) {
  const Query& query = query_of(data);
  std::size_t edge = 0;
  for (int i = 0; i < objects; ++i)
    for (std::uint64_t k = query.cells->first[indices[i]]; k < query.cells->first[indices[i] + 1]; ++k, ++edge) {
      write_number(query.cells->neighbours[k], numbers + 2 * edge);
      ranks[edge] = query.rank_of(query.cells->neighbours[k]);
      if (weights > 0) weight[edge] = 1;
    }
  *status = ZOLTAN_OK;
}

class Zoltan {
 public:
  explicit Zoltan(MPI_Comm communicator) {
    float version = 0;
    if (Zoltan_Initialize(0, nullptr, &version) == ZOLTAN_OK) zoltan_ = Zoltan_Create(communicator);
    if (!zoltan_) throw Error(ErrorCode::Internal, "Zoltan could not be set up");
  }
  ~Zoltan() { Zoltan_Destroy(&zoltan_); }
  Zoltan(const Zoltan&) = delete;
  Zoltan& operator=(const Zoltan&) = delete;

  void set(const char* name, const std::string& value) {
    if (Zoltan_Set_Param(zoltan_, name, value.c_str()) != ZOLTAN_OK)
      throw Error(ErrorCode::Internal, std::string("Zoltan does not take the parameter ") + name);
  }
  Zoltan_Struct* get() { return zoltan_; }

 private:
  Zoltan_Struct* zoltan_ = nullptr;
};

void prepare(Zoltan& zoltan, std::uint32_t part_count, double imbalance, bool weighted, Query& query) {
  zoltan.set("DEBUG_LEVEL", "0");
  zoltan.set("LB_METHOD", "GRAPH");
  zoltan.set("GRAPH_PACKAGE", "PHG");
  zoltan.set("LB_APPROACH", "PARTITION");
  zoltan.set("RETURN_LISTS", "PARTS");
  zoltan.set("NUM_GID_ENTRIES", "2");
  zoltan.set("NUM_LID_ENTRIES", "1");
  zoltan.set("NUM_GLOBAL_PARTS", std::to_string(part_count));
  zoltan.set("IMBALANCE_TOL", std::to_string(1 + imbalance));
  zoltan.set("OBJ_WEIGHT_DIM", weighted ? "1" : "0");
  zoltan.set("SEED", "20100614");
  Zoltan_Set_Num_Obj_Fn(zoltan.get(), count_objects, &query);
  Zoltan_Set_Obj_List_Fn(zoltan.get(), list_objects, &query);
  Zoltan_Set_Num_Edges_Multi_Fn(zoltan.get(), count_edges, &query);
  Zoltan_Set_Edge_List_Multi_Fn(zoltan.get(), list_edges, &query);
}

bool fits(const DistributedCells& cells, std::uint32_t part_count, double imbalance, std::size_t targets) {
  constexpr auto most = static_cast<std::size_t>(std::numeric_limits<int>::max());
  return !cells.first.empty() && cells.first.back() == cells.neighbours.size() && targets == cells.first.size() - 1 &&
         targets < most && part_count > 0 && part_count < most && imbalance >= 0 &&
         (cells.weights.empty() || cells.weights.size() == targets) &&
         std::ranges::all_of(cells.weights, [](std::int64_t w) { return w > 0; });
}

/// Whether weights are given anywhere. Throws on all ranks when one rank's input does not fit.
bool agree(bool fitting, bool weighted, MPI_Comm communicator) {
  std::array<int, 2> flags{fitting ? 0 : 1, weighted ? 1 : 0};
  MPI_Allreduce(MPI_IN_PLACE, flags.data(), 2, MPI_INT, MPI_MAX, communicator);
  if (flags[0])
    throw Error(ErrorCode::InvalidArgument, "a distributed graph has arrays that do not fit or weights of zero");
  return flags[1];
}

}  // namespace

void partition_zoltan(const DistributedCells& cells, std::uint32_t part_count, double imbalance,
                      std::span<std::uint32_t> targets, int mpi_communicator) {
  MPI_Comm communicator = MPI_Comm_f2c(mpi_communicator);
  const bool weighted = agree(fits(cells, part_count, imbalance, targets.size()), !cells.weights.empty(), communicator);
  int ranks = 0;
  MPI_Comm_size(communicator, &ranks);
  Query query{&cells, std::vector<std::uint64_t>(static_cast<std::size_t>(ranks))};
  MPI_Allgather(&cells.first_cell, 1, MPI_UINT64_T, query.first_of_rank.data(), 1, MPI_UINT64_T, communicator);
  Zoltan zoltan(communicator);
  prepare(zoltan, part_count, imbalance, weighted, query);
  int changes = 0, number_words = 0, index_words = 0, imports = 0, exports = 0;
  ZOLTAN_ID_PTR import_numbers = nullptr, import_indices = nullptr, export_numbers = nullptr, export_indices = nullptr;
  int *import_ranks = nullptr, *import_parts = nullptr, *export_ranks = nullptr, *export_parts = nullptr;
  const int status = Zoltan_LB_Partition(zoltan.get(), &changes, &number_words, &index_words, &imports, &import_numbers,
                                         &import_indices, &import_ranks, &import_parts, &exports, &export_numbers,
                                         &export_indices, &export_ranks, &export_parts);
  for (int i = 0; i < exports; ++i) targets[export_indices[i]] = static_cast<std::uint32_t>(export_parts[i]);
  Zoltan_LB_Free_Part(&import_numbers, &import_indices, &import_ranks, &import_parts);
  Zoltan_LB_Free_Part(&export_numbers, &export_indices, &export_ranks, &export_parts);
  if (status != ZOLTAN_OK && status != ZOLTAN_WARN) throw Error(ErrorCode::Internal, "Zoltan could not partition");
}

}  // namespace tetloom
