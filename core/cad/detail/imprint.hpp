#pragma once
// Fusing touching bodies so that they share faces. Private to core/cad.
#include "core/cad/detail/healing.hpp"

namespace tetloom::cad {

/// General Fuse (BOPAlgo) of all solids and sheets: afterwards bodies that touch share faces, edges and vertices, and
/// overlapping ones are cut into parts. Names and colours follow; where two become one the first in the file wins.
/// Returns whether anything may have changed. Errors: InputUnsuitable when OpenCASCADE cannot fuse them; Cancelled.
bool imprint(Document& document, std::vector<HealingStep>& steps, const CancelToken* cancel);

}  // namespace tetloom::cad
