#pragma once
// Patches that were changed go back into their mesh.
#include <span>
#include <vector>

#include "mesher/second_order/bad_patches.hpp"
#include "mesher/second_order/mid_node_places.hpp"

namespace tetloom::second_order {

/// The tets of `patches` take the place of those that they were made of: under the same number as far as they are
/// there, then in places that became free, then at the end. New points become the last vertices. The mid nodes are
/// those of the edges that there are now, and `curved` has their new numbers; those inside lie in the middle. Linear.
/// Pre: what lies on the hull and on the surface has not changed; of the points of a patch the last one is unused.
void exchange_patches(std::span<const BadPatch> patches, std::vector<CurvedNode>& curved, Mesh& mesh);

}  // namespace tetloom::second_order
