#pragma once
// Mid nodes are moved until every cell of second order is proven valid.
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "mesher/second_order/mid_node_places.hpp"
#include "tetloom/mesh_data.hpp"
#include "tetloom/tasks.hpp"

namespace tetloom::second_order {

/// What became of curved mid nodes.
struct Straightening {
  std::vector<std::uint32_t> moved;   ///< mid nodes inside of regions that are not in the middle, ascending
  std::vector<CurvedNode> off_model;  ///< those of `curved` that had to leave the model, ascending
  double min_scaled_jacobian = 1;     ///< a lower bound over all cells; at most 1
  std::size_t not_positive = 0;       ///< cells whose bound is not positive
};

/// Puts the nodes of `curved` in their places. Where the Jacobian of a cell is then less than `least` times that of the
/// straight cell somewhere, mid nodes that tets alone have inside of the region move to where the least Jacobian of the
/// tets around their edge is largest, as far as it takes; where that does not suffice, mid nodes of the cell are pulled
/// towards the middle of their edges, as little as it takes, those that follow one another by the same share. Ends
/// always: a cell whose mid nodes are all in the middle is straight. The result does not depend on the number of
/// threads.
///
/// Pre: mesh.mid_to_vert is there, its nodes inside of regions are in the middle, cells are positive, 0 <= least < 1;
/// what a node follows is in `curved` and follows nothing. Errors: what the runner throws.
Straightening straighten(std::span<const CurvedNode> curved, double least, Mesh& mesh, const TaskRunner& runner);

/// The same where there are no hopeless tets: those whose Jacobian is less at a vertex all of whose edges lie on the
/// surface, so that moving mid nodes inside does not help. Else the nodes of `curved` are put on the model, nothing is
/// moved inside or pulled back, and `hopeless` has them, ascending. Pre: as above, and the mesh has tets only.
std::optional<Straightening> straighten_unless_hopeless(std::span<const CurvedNode> curved, double least, Mesh& mesh,
                                                        std::vector<std::uint32_t>& hopeless, const TaskRunner& runner);

}  // namespace tetloom::second_order
