#pragma once
// What the parts have made, handed on.
#include "mesher/parts/all_parts.hpp"
#include "mesher/volume/volume_parts.hpp"

namespace tetloom::parts {

/// Each part's tets with the vertices that they use, and its triangles. New points are numbered by the part that made
/// them, then in the order in which they were made. Figures of `volume` stay; the states are emptied. A collective
/// call. Errors: Cancelled.
void hand_on_parts(const AllParts& all, VolumeParts& volume);

}  // namespace tetloom::parts
