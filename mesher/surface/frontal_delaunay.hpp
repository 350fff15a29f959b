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

/// Refines a patch made of its rim alone. Pre: surface.smooth(); vertices carry places and sizes.
/// Post: all triangles are counter-clockwise in the plane; fixed edges and rim vertices are untouched. `keep_going` is
/// asked every few thousand points and ends the work when it returns false.
void refine_frontal(Patch& patch, const PatchSurface& surface, const std::function<bool()>& keep_going);

}  // namespace tetloom
