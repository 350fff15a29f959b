#pragma once
// Triangles between the pieces of a rim that need not be that of the model's face.
#include <functional>
#include <span>
#include <vector>

#include "mesher/surface/face_mesher.hpp"
#include "mesher/surface/face_rim.hpp"

namespace tetloom {

/// The triangles, or why there are none.
struct RimMesh {
  FaceMesh mesh;
  std::vector<std::uint32_t> crossing;  ///< nodes of the pieces that are in each other's way
};

/// Meshes what `rim` bounds, in the parameter plane of `geometry`, which it asks for what FaceOverPlane answers.
/// `nodes` are the points of the rim's nodes. The verdict is Ok, RimCrosses, RimNotClosed, or NotTriangulated where a
/// triangle faces away from the surface. Deterministic; may be called for several rims at once. As mesh_face for
/// `keep_going`.
RimMesh mesh_in_rim(FaceRim rim, FaceGeometry& geometry, std::span<const Vec3> nodes, const SizeField& sizes,
                    const std::function<bool()>& keep_going);

}  // namespace tetloom
