#pragma once
// What `adapt` starts from: the mesh, the model and the metric.
#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "apps/tetloom/options.hpp"
#include "tetloom/host.hpp"
#include "tetloom/io.hpp"
#include "tetloom/metric.hpp"
#include "tetloom/partition.hpp"
#include "tetloom/tasks.hpp"
#include "threading/comm/shared_work.hpp"

namespace tetloom::app {

/// Points of the parts that a rank has of a mesh, by global id, ascending.
struct PointsOfRank {
  std::vector<std::uint64_t> ids;
  std::vector<std::uint64_t> numbers;  ///< in the whole mesh
  SolutionSize whole;                  ///< what that has
};

/// Everything that an adaptation is made from, as it was read.
struct AdaptInput {
  std::optional<PartitionedMesh> parts;  ///< the mesh where it lies, or else:
  std::optional<Mesh> mesh;              ///< the whole of it, with the fields that the command names
  PointsOfRank points;                   ///< of `parts`, where the metric comes from a file
  ModelDocument document;                ///< without a model where none is asked for
  MeshField metric;                      ///< values from a file, at `points` of parts, or from a field; without any:
                                         ///< to be made from a solution
  adapt::TensorOrder order = adapt::TensorOrder::Vtk;
};

/// Whether fields of a mesh in that format lie in a file of their own beside it.
bool has_fields_beside(const std::filesystem::path& mesh);
/// That file, of the same name: .solb beside .meshb, .sol beside .mesh.
std::filesystem::path fields_beside(const std::filesystem::path& mesh);

/// The mesh, where it lies in pieces: each rank reads some of them; a single one has the whole in the end. Or a slice
/// of one file for each rank, with its values of a file of fields beside it. Nothing, where every rank has to read all
/// of it. In SharedWork::together. Errors: those of read_parts, read_slices and read_solution_at.
AdaptInput read_pieces_of(const AdaptCommand& command, const SharedWork& work, const CancelToken& cancel);

/// Reads what the command names, but for the model and a mesh that is there. Errors: as those of the readers;
/// InputUnsuitable for fields that are not there.
void read_adapt_input(const AdaptCommand& command, const CancelToken& cancel, AdaptInput& input);

/// Of the whole mesh. Consumes the values of `input.metric`. Errors: as those of the functions of adapt/metric.
adapt::MetricField make_metric(const AdaptCommand& command, AdaptInput& input, const TaskRunner& runner);
/// Of a mesh in parts, those of this rank.
PerPart<adapt::MetricField> make_metric_of_parts(const AdaptCommand& command, const AdaptInput& input,
                                                 const TaskRunner& runner);

}  // namespace tetloom::app
