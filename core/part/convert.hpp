#pragma once
// Between a mesh in one piece, as it is read, written and validated, and the mesh of a part.
#include <cstdint>
#include <span>

#include "tetloom/mesh_data.hpp"
#include "tetloom/part_mesh.hpp"

namespace tetloom {

/// The whole of `mesh` as one part. The global id of a vertex is its index in `mesh`; points that no cell uses are left
/// out. Everything is connected (connect_cells).
///
/// Errors: InvalidArgument (array lengths, indices); InputUnsuitable when `mesh` has no volume cells, when a triangle,
/// quadrilateral or edge belongs to no cell (the element and a point are named), when an entity's index does not fit
/// PackedEntity, or when it is too large for a part.
PartMesh make_part(const Mesh& mesh);

/// The same for a piece of a larger mesh: vertices have the given global ids, one for each point of `mesh`, and only
/// those model entities are kept that the piece lies on or that have attributes or sides. Errors: also InvalidArgument
/// when there are too few or too many ids, and InputUnsuitable when two points have the same one.
PartMesh make_part(const Mesh& mesh, std::span<const std::uint64_t> global_ids);

/// The mesh of a part on its own. Points stand by global id, elements as in the part.
Mesh make_mesh(const PartMesh& part);

/// Adds what parts know of model entities to the tables of `mesh`.
void name_entities(std::span<const PartEntity> entities, Mesh& mesh);

}  // namespace tetloom
