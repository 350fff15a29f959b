#pragma once
// What has become of parts, put together.
#include <vector>

#include "adapt/parts/cut_parts.hpp"

namespace tetloom::adapt {

/// The share of this rank after a round, and how it fits to those of the others. Parts are emptied. Vertices that parts
/// share are numbered with the first of them, so the numbers depend on the parts alone. In SharedWork::together.
/// Errors: std::bad_alloc where there are more tets than can be counted.
WholeMesh join_parts(const RoundShare& old, std::vector<PartOfWhole>& parts, ShareLinks& links, const SharedWork& work);

}  // namespace tetloom::adapt
