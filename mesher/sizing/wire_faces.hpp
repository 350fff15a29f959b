#pragma once
// Faces around something so thin that the floor of sizes would take its shape. Private to mesher/sizing.
#include "core/geometry/model.hpp"
#include "mesher/sizing/size_targets.hpp"

namespace tetloom {

/// Whether the face goes around a wire or a ball: the surface opposite to it, through the material and one diameter of
/// curvature away, is the face itself. Asked only where the curvature rule wants sizes below the floor. `facets` are
/// those of the face. Complexity: a few projections.
bool encloses_wire(FaceGeometry& face, const FaceSides& sides, const Tessellation& facets, const SizeTargets& targets);

}  // namespace tetloom
