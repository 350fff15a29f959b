#pragma once
// What the parts have made, handed on.
#include "mesher/parts/all_parts.hpp"
#include "mesher/volume/volume_parts.hpp"

namespace tetloom::parts {

/// The parts of a complex, as they are handed on.
struct HandedOn {
  std::vector<VolumePart> parts;  ///< those of this rank; points and triangles numbered as in the complex
  std::uint64_t new_points = 0;   ///< of all parts
};

// New points are numbered by the part that made them, then in the order in which they were made. The states are emptied
// first.

/// Each part's tets with the vertices that they use, and its triangles. A collective call. Errors: Cancelled.
HandedOn hand_on_parts(const AllParts& all);

}  // namespace tetloom::parts
