#pragma once
// Spreads the free vertices of a mesh as a size field asks, so that its tetrahedra become better throughout: what makes
// the worst of them better cannot mend a vertex too many or too few around a place.
//
// Rounds of two steps. Every vertex goes to the mean of the circumcentres of its tets, with their volumes and a density
// as weights (optimal Delaunay triangulations, Chen & Xu 2004; as a way to make meshes, Alliez et al. 2005), and on by
// a share of the step before (Polyak 1964). Then exchanges of tets follow, towards a Delaunay mesh (`delaunay_flips`).
// Departures: all vertices move at once, from sums over tets, so that no star is looked for; the density is 1/size^4; a
// vertex stays where a tet would become too poor; the Delaunay mesh is not made anew.
#include <cstddef>
#include <cstdint>

#include "core/tets/working_mesh.hpp"
#include "tetloom/size_field.hpp"
#include "tetloom/tasks.hpp"

namespace tetloom::tets {

/// Moves the vertices of the tets from `first` on that are neither fixed nor vertices of the tets before it, and
/// exchanges those tets. No tet gets worse than both the cubed quality `floor` and what was in its place. The result
/// depends on the mesh, the field and `floor` alone. Linear; meanwhile 61 bytes per point and 4 per tet. Returns how
/// often a vertex was moved. Errors: Cancelled, which leaves a mesh that is valid but for its qualities.
std::size_t relax(WorkingMesh& mesh, std::uint32_t first, const SizeField& sizes, double floor,
                  const TaskRunner& runner);

}  // namespace tetloom::tets
