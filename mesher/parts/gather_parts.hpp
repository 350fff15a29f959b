#pragma once
// What the parts have made, put together and looked at as a whole.
#include <span>

#include "mesher/parts/part_state.hpp"

namespace tetloom::parts {

/// Sends the faces with nothing of the part behind them to the neighbours.
void send_open_faces(const SharedInput& input, PartState& state, PartTask& task);

/// Notes those of the part's open faces that no neighbour has told of; a fault where several have.
void check_open_faces(PartState& state, PartTask& task);

/// All tets, those of each part together, over the given points and then the others, each by the part that made it.
/// The states are emptied on the way. Pre: these are all parts.
volume::Filling gather_parts(std::span<const Vec3> given, std::span<PartState* const> states, const TaskRunner& runner);

}  // namespace tetloom::parts
