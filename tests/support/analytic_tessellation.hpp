#pragma once
// Facets of the faces of the analytic test models.
#include "tests/support/analytic_shapes.hpp"

namespace tetloom::test_models {

/// As FaceGeometry::tessellate. Flat polygons are fans, discs have one inner point, other faces are grids.
Tessellation tessellate_face(const Parts& parts, ModelFaceId id, double chord, double angle);

}  // namespace tetloom::test_models
