#pragma once
// Faces and edges that are too small for the mesh: what curves there is eliminated from it and asks for no sizes.
// Private to mesher/sizing.
#include "tetloom/model.hpp"

namespace tetloom {

/// The area of all facets.
double area_of(const Tessellation& facets);

/// Twice the area of the facets over the length of the face's rim: the width of a long face. Seams are no rim. Infinite
/// where there is none.
double mean_width(const GeometricModel& model, ModelFaceId face, const Tessellation& facets);

/// The length of an edge, within a few percent, as far as `most`.
double length_up_to(EdgeGeometry& edge, double most);

}  // namespace tetloom
