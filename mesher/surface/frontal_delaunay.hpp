#pragma once
// Points inside a face: Delaunay insertion in the metric that the surface and the size field induce on the plane, at
// places that make the new triangles equilateral.
//
// Rebay (1993) chooses the point on the perpendicular of an edge between a finished and an unfinished triangle;
// Borouchaki et al. (1997) make the Delaunay cavity in the metric at the new point. Departures: a candidate is
// corrected once with the metric halfway to it; a second pass inserts circumcentres where the front left large
// triangles behind.
#include <functional>

#include "mesher/surface/patch.hpp"

namespace tetloom {

/// How far the triangles inside may be larger than the field says: up to `factor` times, and from vertex to vertex by
/// no more than `growth` times their distance.
struct Coarsening {
  double factor = 1;
  double growth = 0.7;
};

/// Refines a patch made of its rim alone. Pre: surface.smooth(); vertices carry places and sizes.
/// Post: all triangles are counter-clockwise in the plane; fixed edges and rim vertices are untouched. `keep_going` is
/// asked every few thousand points and ends the work when it returns false. With a coarsening, the sizes of the new
/// vertices are those that the refinement went by.
void refine_frontal(Patch& patch, const PatchSurface& surface, const std::function<bool()>& keep_going,
                    const Coarsening& coarsening = {});

}  // namespace tetloom
