#pragma once
// Which triangles are faces of the mesh.
#include "mesher/tets/recovery.hpp"
#include "mesher/tets/triangle_table.hpp"

namespace tetloom::tets {

/// The triangles with their numbers; of repeated ones the first.
TriangleTable make_table(std::span<const TriangleVerts> triangles);

/// Fixes the triangles that are faces of the mesh, on both sides, and returns the others and the repeated ones,
/// ascending.
std::vector<std::uint32_t> fix_triangles(TetMesh& mesh, std::span<const TriangleVerts> triangles,
                                         const TriangleTable& table, const TaskRunner& runner);

}  // namespace tetloom::tets
