#pragma once
// What is said of a mesh in parts as a whole.
#include "apps/tetloom/report.hpp"
#include "tetloom/partition.hpp"
#include "threading/parts/parts_summary.hpp"

namespace tetloom::app {

/// Notes counts, quality and digest of the whole mesh, which nobody has to hold.
void note_summary(const PartsSummary& summary, const PartsFigures& figures, RunReport& report);

}  // namespace tetloom::app
