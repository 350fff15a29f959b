#pragma once
// Faces and edges that are too small for the mesh: what curves there is eliminated from it and asks for no sizes.
// Private to mesher/sizing.
#include "core/geometry/model.hpp"

namespace tetloom {

/// Twice the area over the length of the rim: the width of a long face. Infinite where there is no rim. Seams count as
/// rim.
double mean_width(const Tessellation& facets);

/// The length of an edge, within a few percent, as far as `most`.
double length_up_to(EdgeGeometry& edge, double most);

}  // namespace tetloom
