#pragma once
// Fills a complex with a lattice core and a Delaunay shell around it.
//
// The points of the lattices inside, the tetrahedra of the undisturbed lattice in closed form, the Delaunay
// tetrahedralisation of everything else, stitched to them face to face; the boundary recovered where it is missing; the
// tetrahedra between the core and the surface kept, those outside and in the core's place dropped; all of it optimised.
// The idea is de Cougny & Shephard's (1999), who fill interior octants by templates and connect them to the surface.
#include "mesher/intersection/triangle_tree.hpp"
#include "mesher/tets/tet_mesh.hpp"
#include "mesher/volume/region_coloring.hpp"
#include "mesher/volume/surface_freedom.hpp"

namespace tetloom::volume {

struct LatticeInput {
  const Complex& complex;
  const intersection::TriangleTree& tree;  ///< of the complex
  const SizeField& sizes;
  const SurfaceFreedom* freedom = nullptr;  ///< null: the surface stays
};

struct LatticeFilling {
  tets::TetMesh mesh;  ///< points: the complex's, then new ones; some may be used by no tet
  std::vector<std::array<std::uint32_t, 3>> tri_to_vert;  ///< the complex's triangles; empty: as they were
  FillingFigures figures;
  FillingVerdict verdict;  ///< not good: what is in the way, and the mesh is unspecified
};

/// The result depends on the arguments alone. Errors: Cancelled, OutOfMemory.
LatticeFilling fill_by_lattice(const LatticeInput& input, const TaskRunner& runner);

/// The tets and the points that they use; the first `given` points are kept in any case. `mesh` is emptied on the way,
/// so that the two are never there at once.
Filling to_filling(tets::TetMesh&& mesh, std::size_t given);

}  // namespace tetloom::volume
