#pragma once
// What layers leave of a side face is meshed anew inside of their top.
#include <functional>
#include <span>
#include <vector>

#include "mesher/layers/side_faces.hpp"
#include "mesher/surface/face_mesher.hpp"
#include "tetloom/size_field.hpp"

namespace tetloom::layers {

/// A side face with its mesh above the layers. A vertex of `mesh` that is not inside of the face is an index of
/// `nodes`.
struct SideMesh {
  struct Node {
    std::uint32_t vert = kNone;   ///< of the given mesh
    std::uint32_t curve = kNone;  ///< else: the top of this curve
  };
  std::uint32_t face = 0;
  FaceMesh mesh;
  std::vector<Node> nodes;
  std::vector<std::uint32_t> in_the_way;  ///< where the verdict is not Ok: curves to lower
};

/// Meshes the rest of a side face, in the plane of its shape. `tops` are those of all curves. The verdict of the mesh
/// says whether that was possible. May be called for several faces at once. `keep_going` as in mesh_face.
SideMesh mesh_rest(const SideFaces& sides, std::size_t side, std::span<const CurveTop> tops, const SizeField& sizes,
                   const std::function<bool()>& keep_going);

}  // namespace tetloom::layers
