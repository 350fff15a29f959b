#pragma once
// Triangles between the pieces of a rim that need not be that of the model's face.
#include <functional>
#include <span>

#include "mesher/surface/face_mesher.hpp"
#include "mesher/surface/face_rim.hpp"

namespace tetloom {

/// Meshes what `rim` bounds, in the parameter plane of `geometry`, which it asks for what FaceOverPlane answers.
/// `nodes` are the points of the rim's nodes. The verdict is Ok or RimNotClosed. Deterministic; may be called for
/// several rims at once. As mesh_face for `keep_going`.
FaceMesh mesh_in_rim(FaceRim rim, FaceGeometry& geometry, std::span<const Vec3> nodes, const SizeField& sizes,
                     const std::function<bool()>& keep_going);

}  // namespace tetloom
