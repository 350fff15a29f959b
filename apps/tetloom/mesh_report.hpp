#pragma once
// What the report says of a run of `mesh`.
#include "apps/tetloom/report.hpp"
#include "tetloom/mesh.hpp"
#include "tetloom/tasks.hpp"

namespace tetloom::app {

/// How the run went; and what it was asked for.
void note_run(const MeshResult& result, const GeometricModel& model, const MeshOptions& options, RunReport& report);

/// That solids were made anew before the model was meshed, with a warning; lists of them follow each other, each
/// numbered in the model that the last one left.
void note_rebuilt(std::span<const std::vector<ModelRegionId>> lists, RunReport& report);

/// How the volume was filled.
void note_filling(const FillingFigures& figures, const QualityGoals& goals, RunReport& report);

/// Counts, quality and digest of `mesh`, unless it is empty.
void measure_mesh(const Mesh& mesh, const SizeField& sizes, const TaskRunner& runner, RunReport& report);

}  // namespace tetloom::app
