#pragma once
// What is true of every mesh that adapt_mesh hands back.
#include "tetloom/host.hpp"
#include "tetloom/metric.hpp"

namespace tetloom::adapt {

/// Throws Error(Internal), with a place and the first elements, unless all tets are positive by the exact predicate.
/// Linear.
void check_positive(const TetView& mesh, const BlockLoop& loop);

}  // namespace tetloom::adapt
