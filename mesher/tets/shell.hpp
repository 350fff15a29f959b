#pragma once
// Joins the tetrahedra around a core of other ones to it, and tells what lies where.
#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "core/tets/fault.hpp"
#include "core/tets/tet_mesh.hpp"
#include "core/tets/triangle_verts.hpp"
#include "tetloom/error.hpp"
#include "tetloom/model.hpp"
#include "tetloom/tasks.hpp"
#include "tetloom/vec.hpp"

namespace tetloom::tets {

/// The surface between regions. Triangles are counter-clockwise seen from the tip of their normal.
struct Surface {
  std::span<const TriangleVerts> tri_to_vert;
  std::span<const FaceSides> tri_to_sides;
};

/// Fixes the faces of `shell` that are open faces of `core`, on both sides. Both meshes have the same vertex ids.
/// Returns how many open faces are not there.
std::size_t fix_core_faces(TetMesh& shell, const TetMesh& core, std::span<const FaceCode> open_faces);

/// Appends those tets of `shell` to `core` that lie in regions, links them to the core through its open faces and names
/// the region of each tet, of the core too. A flood of tets that fixed faces surround is in the region that all surface
/// triangles around it name, outside when they name none or when it reaches the hull where that is free, and in the
/// core's place when an open face shows it its back. Fixed faces of the result are those of the surface. `shell` is
/// emptied; its points go to the core. `core` needs no regions before. Pre: all triangles and all open faces are fixed
/// faces of `shell`, and no others. Linear. Errors: Cancelled.
Fault join_shell(TetMesh& core, TetMesh&& shell, std::span<const FaceCode> open_faces, const Surface& surface,
                 const TaskRunner& runner);

}  // namespace tetloom::tets
