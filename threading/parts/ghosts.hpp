#pragma once
// Copies of the cells around a part, and numbers that are the same everywhere.
#include <array>
#include <cstdint>

#include "tetloom/partition.hpp"
#include "tetloom/tasks.hpp"

namespace tetloom {

/// A part with ghosts: copies of other parts' cells around it. Own vertices and cells come first, with the numbers that
/// they have in the part; ghosts follow by sender, in the sender's order. Connected throughout, so that every own cell
/// has its neighbours unless the whole mesh ends there.
struct GhostedPart {
  PartMesh mesh;
  std::size_t own_vertices = 0;
  std::array<std::size_t, kCellKinds> own_cells{};
  GrowingArray<Copy> ghost_vertices;                       ///< owner, and its number there; one per ghost vertex
  std::array<GrowingArray<Copy>, kCellKinds> ghost_cells;  ///< the part that has the cell, and its number there
};

/// Around every part `layers` layers of cells: the first are all cells of other parts that touch the part in a vertex,
/// each further one the cells that touch the layer before. With their vertices, boundary elements, fields and model
/// entities. The mesh itself is not changed; ghosts are a copy of it as it is now.
/// A collective call. Time and memory grow with the part and its ghosts. Errors: InvalidArgument (layers < 1),
/// Cancelled, OutOfMemory.
PerPart<GhostedPart> make_ghosts(const PartitionedMesh& mesh, int layers, const TaskRunner& runner,
                                 Trace* trace = nullptr);

/// The same of a mesh that is given up, without a copy of it. Nothing is connected afterwards.
PerPart<GhostedPart> add_ghosts(PartitionedMesh&& mesh, int layers, const TaskRunner& runner, Trace* trace = nullptr);

/// Brings the values of vertex field `field` (an index into mesh.vertex_fields) from the owners' parts to all copies.
/// For fields that each part computed for the vertices that it owns. A collective call.
void update_copies(PartitionedMesh& mesh, std::size_t field, const TaskRunner& runner, Trace* trace = nullptr);

/// Gives all vertices new global ids 0, 1, 2 … : those that part 0 owns in their order, then those that part 1 owns,
/// and so on. Depends on the parts alone, never on ranks, threads or arrival. A collective call.
void assign_global_ids(PartitionedMesh& mesh, const TaskRunner& runner, Trace* trace = nullptr);

}  // namespace tetloom
