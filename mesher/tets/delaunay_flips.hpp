#pragma once
// Brings a mesh whose vertices have moved back near to a Delaunay one, by exchanging two tets for three and three for
// two (Lawson 1977; Joe 1991).
#include <cstddef>
#include <cstdint>

#include "core/tets/working_mesh.hpp"
#include "tetloom/tasks.hpp"

namespace tetloom::tets {

/// Looks at every tet from `first` on that is there at the start, in order of ids, and at the faces behind which
/// another vertex lies inside of its circumsphere. What is exchanged gives tets of cubed quality `floor` at least, or
/// none worse than before. Tets before `first` stay. Returns the number of exchanges. Linear. Errors: Cancelled.
std::size_t flip_to_delaunay(WorkingMesh& mesh, std::uint32_t first, double floor, const TaskRunner& runner);

}  // namespace tetloom::tets
