#pragma once
// What the parts have made, handed on as parts.
#include "mesher/parts/part_state.hpp"
#include "mesher/volume/volume_parts.hpp"

namespace tetloom::parts {

struct HandedOn {
  std::vector<VolumePart> parts;  ///< those of this rank; points and triangles numbered as in the complex
  std::uint64_t new_points = 0;   ///< of all parts
};

/// Each part's tets with the vertices that they use. New points are numbered by the part that made them, as
/// gather_parts numbers them. The states are emptied on the way. A collective call. Errors: Cancelled.
HandedOn hand_on_parts(const SharedInput& input, PerPart<PartState>& states, Communicator& communicator,
                       const TaskRunner& runner);

}  // namespace tetloom::parts
