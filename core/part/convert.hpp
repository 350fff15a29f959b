#pragma once
// Between a mesh in one piece, as it is read, written and validated, and the mesh of a part.
#include "core/mesh/mesh.hpp"
#include "core/part/part_mesh.hpp"

namespace tetloom {

/// The whole of `mesh` as one part. The global id of a vertex is its index in `mesh`; points that no cell uses are left
/// out. Everything is connected (connect_cells).
///
/// Errors: InvalidArgument (array lengths, indices); InputUnsuitable when `mesh` has no volume cells, when a triangle,
/// quadrilateral or edge belongs to no cell (the element and a point are named), or when it is too large for a part.
PartMesh make_part(const Mesh& mesh);

/// The mesh of a part on its own. Points stand by global id, elements as in the part.
Mesh make_mesh(const PartMesh& part);

}  // namespace tetloom
