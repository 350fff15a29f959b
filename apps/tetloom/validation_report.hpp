#pragma once
// What the report says of whether a mesh is valid.
#include "apps/tetloom/report.hpp"
#include "tetloom/check.hpp"

namespace tetloom::app {

/// Validates `mesh`, adds "validation" to the report, and its problems as errors of the run: exit status 4.
ValidationReport note_validation(const Mesh& mesh, const BlockLoop& loop, RunReport& report);

}  // namespace tetloom::app
