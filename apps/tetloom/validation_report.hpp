#pragma once
// What the report says of whether a mesh is valid.
#include "apps/tetloom/report.hpp"
#include "tetloom/check.hpp"
#include "tetloom/partition.hpp"
#include "threading/parts/parts_summary.hpp"

namespace tetloom::app {

/// Validates `mesh`, adds "validation" to the report, and its problems as errors of the run: exit status 4.
ValidationReport note_validation(const Mesh& mesh, const BlockLoop& loop, RunReport& report);

/// The same for a mesh in parts, where they lie: that they fit together (validate_parts) and that all cells are
/// positive. What validate_mesh knows of surfaces and classifications is left out, and so are its counts but for that
/// of points without an entity. `fit` is that of this rank. A collective call.
void note_validation(const PartitionedMesh& mesh, const PartsReport& fit, const PartsSummary& summary,
                     RunReport& report);

}  // namespace tetloom::app
