#pragma once
// What each rank had to hold.
#include "apps/tetloom/report.hpp"
#include "tetloom/communicator.hpp"
#include "tetloom/model.hpp"
#include "tetloom/partition.hpp"

namespace tetloom::app {

/// Adds "ranks" to the report, where there are several: [{"peak_bytes", "model_bytes", "tets"}, …], an entry for each.
/// `tets`: those of the result that this rank has. `model`: may be null; "model_bytes" is null where it is, and where
/// each rank has the whole model. A collective call.
void note_ranks(Communicator& communicator, std::uint64_t tets, const GeometricModel* model, RunReport& report);

/// Of its parts.
/// Adds "model_bytes" to the table of parts (see parts_json): the bytes of all shapes of edges and faces that the part
/// has elements on. Nothing where each rank has the whole model. A collective call.
void note_model_bytes(const PartitionedMesh& mesh, const GeometricModel& model, nlohmann::ordered_json& partition);

std::uint64_t tets_of_rank(const PartitionedMesh& mesh);

}  // namespace tetloom::app
