#pragma once
// The first steps of a part: the points of the lattices in its box and their core.
#include "mesher/parts/part_state.hpp"
#include "tetloom/tasks.hpp"

namespace tetloom::parts {

/// Finds the part's own sites and sends those near others.
void find_points(const SharedInput& input, PartState& state, PartTask& task);

/// Where there are several lattices: drops sites near those of finer ones and sends what is left once more.
void drop_near_finer(const SharedInput& input, PartState& state, PartTask& task);

/// Writes the part's share of the core, and sends its points of the shell that others have to know.
void make_core(const SharedInput& input, PartState& state, PartTask& task);

/// Takes the points of the shell that others know.
void take_shell_points(PartState& state, PartTask& task);

}  // namespace tetloom::parts
