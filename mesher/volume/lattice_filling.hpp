#pragma once
// Fills a complex with a lattice core and a Delaunay shell around it.
//
// The points of the lattices inside, the tetrahedra of the undisturbed lattice in closed form, the Delaunay
// tetrahedralisation of everything else, stitched to them face to face; the boundary recovered where it is missing; the
// tetrahedra between the core and the surface kept, those outside and in the core's place dropped; all of it optimised.
// The idea is de Cougny & Shephard's (1999), who fill interior octants by templates and connect them to the surface.
#include "mesher/volume/complex_filling.hpp"
#include "tetloom/tasks.hpp"

namespace tetloom::volume {

/// The result depends on the arguments alone. Errors: Cancelled, OutOfMemory.
FilledMesh fill_by_lattice(const FillingInput& input, const TaskRunner& runner);

}  // namespace tetloom::volume
