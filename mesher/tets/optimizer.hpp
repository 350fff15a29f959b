#pragma once
// Makes the tetrahedra of a mesh better, above all the worst, the surface given.
//
// Where sizes vary, vertices are first spread as the size field asks (`relaxation.hpp`). Then a schedule of passes,
// each over the tets whose quality q, the mean ratio 12 (3V)^(2/3) / (sum of squared edges), is below a threshold:
//   edge removal      an edge's tets are replaced by the best triangulation of its ring (Klincsek 1980; Freitag &
//                     Ollivier-Gooch 1997), where that raises their minimum;
//   vertex motion     one damped Newton step per vertex on the sum of 1/q^3 over its tets;
//   vertex removal    a vertex is merged into a neighbour, where that raises the minimum of its star;
//   point insertion   a point into a poor tet, where that raises the cavity's minimum.
// The last two, in rounds, are for what the others leave below the mean ratio asked for, or so poor that a dihedral
// angle may be below the one asked for: a tet with a smallest angle of a has q^3 <= 2 sin^2 a, so that q > .512 rules
// out 15 degrees. Departure from the papers: none of these visits what is good already, so that the cost is that of one
// look at every tet.
#include <cstddef>
#include <cstdint>
#include <span>

#include "core/tets/tet_mesh.hpp"
#include "mesher/tets/acute_tets.hpp"
#include "mesher/tets/quality_goals.hpp"
#include "tetloom/filling.hpp"
#include "tetloom/size_field.hpp"
#include "tetloom/tasks.hpp"

namespace tetloom::tets {

/// What stays, and how long the optimiser works.
struct OptimizeOptions {
  std::uint32_t fixed_points = 0;  ///< points before this one lie on the given surface: they stay, where they are
  std::uint32_t lattice_tets = 0;  ///< the first so many are of undisturbed lattices: alike, alive, without fixed faces
  std::span<const FaceCode> open_faces = {};  ///< of these, the faces that nothing of the mesh lies behind
  GrowingArray<float>* qualities = nullptr;   ///< gets the cubed quality of every tet, instead of the report's figures
                                              ///< of what the mesh has become
  bool keep_points = false;          ///< numbers of points stay; those that no tet has any more are left where they are
  const SizeField* sizes = nullptr;  ///< not null: vertices are first spread as it asks; outlives the call
  QualityGoals goals;                ///< what removing vertices and inserting points aim at
};

/// Optimises in place; what is dead is dropped, and so are points from `fixed_points` on that no tet has any more.
///
/// Pre: the invariants of TetMesh. Post: they hold, in exact arithmetic; fixed faces are as they were; the smallest
/// quality is not smaller than before; regions keep their volumes up to round-off. The result depends on the mesh and
/// the options alone. Besides the mesh: 4 bytes per tet and 9 bits per point; with sizes 8 and 61.
/// Errors: InvalidArgument for options out of range; Cancelled, which leaves a valid mesh with dead tets.
/// Thread safety: one call per mesh.
OptimizeReport optimize(TetMesh& mesh, const OptimizeOptions& options, const TaskRunner& runner);

}  // namespace tetloom::tets
