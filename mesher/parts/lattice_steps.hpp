#pragma once
// The first steps of a part: the points of the lattices in its box and their core.
#include "mesher/parts/part_state.hpp"
#include "tetloom/tasks.hpp"

namespace tetloom::parts {

/// Finds the part's own sites and sends those near others.
PartShell find_points(const SharedInput& input, PartTask& task);

/// Where there are several lattices: drops sites near those of finer ones and sends what is left once more.
void drop_near_finer(const SharedInput& input, PartShell& shell, PartTask& task);

/// Writes the part's share of the core, and sends its points of the shell that others have to know.
void make_core(const SharedInput& input, PartShell& shell, PartTask& task);

/// Takes the points of the shell that others know.
void take_shell_points(PartShell& shell, PartTask& task);

}  // namespace tetloom::parts
