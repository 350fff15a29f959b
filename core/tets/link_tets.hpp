#pragma once
// A mesh from tetrahedra of which only the vertices are known.
#include <array>
#include <cstdint>
#include <span>

#include "core/tets/fault.hpp"
#include "core/tets/tet_mesh.hpp"
#include "core/tets/triangle_verts.hpp"
#include "tetloom/host.hpp"

namespace tetloom::tets {

/// Makes `tet_to_vert` the tets of `mesh`, which has points only: turned so that their volumes are positive, linked
/// through their faces, with the faces that are `triangles` fixed, those of the hull too. The fault: a tet without
/// volume, tets that overlap at a face, triangles that are no faces. Pre: indices valid, fewer than 2^30 tets.
/// 16 bytes per tet beside the mesh; linear where few faces have the same lowest vertex. Errors: Cancelled.
Fault link_tets(TetMesh& mesh, std::span<const std::array<std::uint32_t, 4>> tet_to_vert,
                std::span<const TriangleVerts> triangles, const BlockLoop& loop);

}  // namespace tetloom::tets
