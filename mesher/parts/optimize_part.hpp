#pragma once
// A part's tets optimised, and looked at in the end.
#include "mesher/parts/part_state.hpp"
#include "mesher/parts/strip.hpp"
#include "tetloom/tasks.hpp"

namespace tetloom::parts {

/// Everything but what lies between parts.
void optimize_inside(const SharedInput& input, PartState& state, PartId part, const TaskRunner& runner);

/// The same for a strip; what is done is counted as the part's, and vertices inside of the strip wait no more.
void optimize_strip(const SharedInput& input, Strip& strip, PartState& state, const TaskRunner& runner);

/// Drops dead tets, improves the surface where that is free and the tets need it, and takes the part's figures.
void finish_part(const SharedInput& input, PartState& state, PartId part, const TaskRunner& runner);

}  // namespace tetloom::parts
