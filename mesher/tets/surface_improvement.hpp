#pragma once
// Makes the tets better that the optimiser had to leave as they are because of the surface: the surface changes.
//
// In rounds, the worst tets first: edges of the surface are swapped, vertices of it slide within their model face, and
// the tets around what has changed are optimised again as those inside are. Last, tets whose angles are still very
// small are widened by what the mean ratio does not see (angle_search.hpp).
#include "mesher/tets/optimizer.hpp"
#include "mesher/tets/surface_geometry.hpp"
#include "tetloom/tasks.hpp"

namespace tetloom::tets {

/// Improves in place the mesh and the triangles of `surface`; what becomes of them is added to `report`, which is the
/// optimiser's of this mesh, or a new one, and its figures of quality are made anew.
///
/// Only tets of a cubed quality below `quality_to_improve` are touched, and tets that share a vertex with them: where
/// sizes vary, fair ones in one round, and then, as elsewhere, those so poor that a dihedral angle may be below the one
/// asked for. Pre: the invariants of TetMesh; the fixed faces are the triangles of `surface`, and
/// options.fixed_points is the count of its points. Post: the invariants hold in exact arithmetic; fixed faces are the
/// triangles of `surface`; the smallest quality is not smaller than before, or than
/// a mean ratio of .04 where that makes angles of .4 to 5.5 degrees larger; points with a face in `point_to_face` lie
/// on it or have not moved, the other points of the surface have not moved; triangles are turned as before and keep
/// their model face. Regions change by what lies between the old surface and the new one. The result depends on the
/// arguments alone, as far as the projector's answers do. Errors: Cancelled, which leaves a valid mesh with dead tets.
/// Thread safety: one call per mesh and projector.
void improve_surface(TetMesh& mesh, const ChangeableSurface& surface, const OptimizeOptions& options,
                     OptimizeReport& report, const TaskRunner& runner);

/// The cubed quality below which tets are improved together with the surface: what is poor, as `goals` say, and where
/// `sizes` are given mean ratios below .8.
double quality_to_improve(const OptimizeOptions& options);

}  // namespace tetloom::tets
