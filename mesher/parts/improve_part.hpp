#pragma once
// The surface improved where one part has all tets at it.
#include "mesher/parts/part_state.hpp"

namespace tetloom::parts {

/// As volume::improve, for the surface inside of the part: points stay that other parts have, too, or that lie within a
/// size of their boxes, where another part may change what lies across a gap. Vertices get new numbers.
void improve_part(const SharedInput& input, PartState& state, PartId part, const TaskRunner& runner);

/// Tells the neighbours which points of the surface the part's tets have.
void send_surface_points(const SharedInput& input, PartState& state, PartTask& task);
/// Takes the same from them.
void take_surface_points(PartState& state, PartTask& task);

}  // namespace tetloom::parts
