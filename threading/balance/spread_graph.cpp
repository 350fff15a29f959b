#include <algorithm>

#include "core/part/adjacency.hpp"
#include "tetloom/tasks.hpp"
#include "threading/balance/graph_partitioners.hpp"
#include "threading/balance/spread_graph_detail.hpp"
#include "threading/comm/neighbor_writers.hpp"
#ifdef TETLOOM_MPI
#include "threading/balance/zoltan_partitioner.hpp"
#endif

namespace tetloom::balance_detail {
namespace {

// Cells are numbered by part, then by kind and index; so those of a rank follow one another.
struct SpreadGraph {
  std::uint64_t first_cell = 0;  // of this rank
  CellLinks<std::uint64_t> links;
  std::vector<std::int64_t> weights;
};

class SpreadGraphBuilder {
 public:
  SpreadGraphBuilder(const PartitionedMesh& mesh, const TaskRunner& runner)
      : mesh_(mesh), runner_(runner), begins_(mesh.part_count() + 1, 0), behind_(mesh.part_count(), mesh.local()) {
    for (const PartId part : mesh.local())
      begins_[part.value + 1] = static_cast<std::int64_t>(mesh.parts.at(part).mesh.cell_count());
    mesh.communicator->sum(begins_);
    for (std::size_t i = 1; i < begins_.size(); ++i) begins_[i] += begins_[i - 1];
  }

  SpreadGraph build() {
    find_cells_behind_shared_faces();
    SpreadGraph graph;
    graph.first_cell = begin_of(first_part_of_rank());
    for (const PartId part : mesh_.local()) add_part(part, graph);
    return graph;
  }

 private:
  std::uint64_t begin_of(PartId part) const { return static_cast<std::uint64_t>(begins_[part.value]); }

  // A rank without parts stands where its parts would be.
  PartId first_part_of_rank() const {
    std::size_t part = 0;
    while (part < mesh_.part_count() &&
           mesh_.communicator->rank_of(PartId(part), mesh_.part_count()) < mesh_.communicator->rank())
      ++part;
    return PartId(part);
  }

  void find_cells_behind_shared_faces() {
    const auto send = [&](PartTask& task) {
      const Part& part = mesh_.parts[task];
      const CellNumbers numbers(part.mesh, begin_of(task.part()));
      detail::NeighborWriters writers(part.boundary.neighbors);
      for (std::size_t i = 0; i < part.boundary.faces.size(); ++i) {
        for (const Copy& copy : part.boundary.faces.copies_of(i)) {
          MessageWriter& writer = writers.to(copy.part);
          writer.put(copy.local);
          writer.put(numbers.number_of(part.boundary.faces.entities[i]));
        }
      }
      writers.send(task);
    };
    const auto receive = [&](PartTask& task) {
      std::vector<std::uint64_t>& behind = behind_[task];
      behind.resize(mesh_.parts[task].boundary.faces.size());
      for (const Message& message : task.inbox()) {
        MessageReader reader(message.bytes);
        while (!reader.at_end()) {
          const auto face = reader.get<std::uint32_t>();
          behind.at(face) = reader.get<std::uint64_t>();
        }
      }
    };
    const std::vector<Step> steps{{"graph: send cells", send, links_of_neighbors(mesh_), {}},
                                  {"graph: hear cells", receive, {}, {}}};
    Schedule(*mesh_.communicator, runner_, mesh_.part_count()).run(steps);
  }

  void add_part(PartId id, SpreadGraph& graph) const {
    const Part& part = mesh_.parts.at(id);
    const auto& shared = part.boundary.faces.entities;
    const std::vector<std::uint64_t>& behind = behind_.at(id);
    std::size_t next = 0;  // shared faces ascend, too
    graph.links.add(part.mesh, CellNumbers(part.mesh, begin_of(id)), [&](CellPlace face) {
      const bool is_shared = next < shared.size() && shared[next] == face;
      return is_shared ? std::optional(behind[next++]) : std::nullopt;
    });
  }

  const PartitionedMesh& mesh_;
  const TaskRunner& runner_;
  std::vector<std::int64_t> begins_;
  PerPart<std::vector<std::uint64_t>> behind_;  // the cell behind each shared face
};

void partition_on_one_rank(const SpreadGraph& graph, std::uint32_t part_count, double imbalance,
                           std::span<std::uint32_t> targets) {
  if (targets.size() >= 0xffffffffu)
    throw Error(ErrorCode::InputUnsuitable, "the mesh has too many cells for Scotch; use rcb or sfc");
  const std::vector<std::uint32_t> neighbours(graph.links.neighbours.begin(), graph.links.neighbours.end());
  partition_scotch({graph.links.first, neighbours, graph.weights}, part_count, imbalance, targets);
}

void partition_on_ranks(const Communicator& communicator, const SpreadGraph& graph, std::uint32_t part_count,
                        double imbalance, std::span<std::uint32_t> targets) {
#ifdef TETLOOM_MPI
  if (const auto handle = communicator.mpi_handle()) {
    partition_zoltan({graph.first_cell, graph.links.first, graph.links.neighbours, graph.weights}, part_count,
                     imbalance, targets, *handle);
    return;
  }
#endif
  static_cast<void>(communicator), static_cast<void>(graph), static_cast<void>(part_count);
  static_cast<void>(imbalance), static_cast<void>(targets);
  throw Error(ErrorCode::InvalidArgument, "graphs on several ranks are cut over MPI alone");
}

}  // namespace

void partition_spread_graph(const PartitionedMesh& mesh, const PerPart<std::vector<std::int64_t>>& weights,
                            std::uint32_t part_count, double imbalance, PerPart<Destinations>& destinations,
                            const TaskRunner& runner) {
  SpreadGraph graph = SpreadGraphBuilder(mesh, runner).build();
  for (const PartId part : mesh.local())
    graph.weights.insert(graph.weights.end(), weights.at(part).begin(), weights.at(part).end());
  Destinations targets(graph.links.first.size() - 1);
  if (mesh.communicator->rank_count() == 1) {
    partition_on_one_rank(graph, part_count, imbalance, targets);
  } else {
    partition_on_ranks(*mesh.communicator, graph, part_count, imbalance, targets);
  }
  auto next = targets.begin();
  for (const PartId part : mesh.local()) {
    Destinations& own = destinations.at(part);
    std::copy_n(next, own.size(), own.begin());
    next += static_cast<std::ptrdiff_t>(own.size());
  }
}

}  // namespace tetloom::balance_detail
