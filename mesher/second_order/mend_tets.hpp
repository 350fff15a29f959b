#pragma once
// Tets that cannot be valid with all mid nodes on the model give way to others.
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "mesher/second_order/mid_node_places.hpp"
#include "tetloom/mesh_data.hpp"
#include "tetloom/tasks.hpp"

namespace tetloom::second_order {

/// Replaces those of the tets `bad`, which ascend, for which there are others that have Jacobians of at least `least`
/// with all mid nodes of the surface where they are, see patch_mender.hpp. The surface stays, vertices inside may move,
/// new ones are the last of the vertices. Edges inside have their mid nodes in the middle then; `curved` has the new
/// numbers. Returns how many tets gave way. The result does not depend on the number of threads.
///
/// Pre: the mesh has tets only, of second order, its mid nodes on the surface are where they are to be, those inside in
/// the middle. Errors: what the runner throws.
std::size_t mend_tets(std::span<const std::uint32_t> bad, double least, std::vector<CurvedNode>& curved, Mesh& mesh,
                      const TaskRunner& runner);

}  // namespace tetloom::second_order
