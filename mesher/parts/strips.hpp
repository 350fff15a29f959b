#pragma once
// What lies between parts: strips of tets on both sides move to one part and are optimised there.
//
// A part cannot move vertices or remove edges between it and others. Where tets at such vertices are poor, the tets
// around them move, first those between two parts, then those where more parts meet; what waits is less in each round
// (de Cougny & Shephard 1999a move what lies between parts for the same reason, and finish in one part).
#include "mesher/parts/part_state.hpp"
#include "tetloom/tasks.hpp"

namespace tetloom::parts {

/// Marks, the first time, what could not change between parts; tells the neighbours at which of the vertices that
/// waited for it the part's tets are poor, and which it has where they do not look for it.
void send_poor(const SharedInput& input, PartTets& part, StripState& strips, PartTask& task);

/// Tells the neighbours which of the vertices where any part's tets are poor the part has, and those that have told of
/// a vertex in any case.
void send_shared(const SharedInput& input, const PartTets& part, StripState& strips, PartTask& task);

/// Takes the strips that other parts are to have out of the mesh and sends them. `between_two`: only those between two
/// parts.
void send_strips(PartTets& part, StripState& strips, bool between_two, FillingPartsFigures::Strips& figures,
                 PartTask& task);

/// Takes the strips that this part is to have, optimises and joins them; what is done is counted in `report`.
void take_strips(const SharedInput& input, PartTets& part, StripState& strips, tets::OptimizeReport& report,
                 PartTask& task);

}  // namespace tetloom::parts
