#pragma once
// Moving cells between parts, with everything that belongs to them.
#include <cstdint>
#include <vector>

#include "threading/partitioned_mesh.hpp"

namespace tetloom {

/// Where each cell of a part goes: tets, then pyramids, prisms and hexahedra, in the order of their blocks.
using Destinations = std::vector<std::uint32_t>;

struct MigrationFigures {
  std::uint64_t cells_sent = 0;  ///< to another part, on all ranks
  std::uint64_t bytes_sent = 0;  ///< of all packets, on all ranks
};

/// Deals all cells anew: each goes to the part that `destinations` names for it, of `part_count` parts, which may be
/// fewer or (many) more than before. What travels: vertices with global ids, coordinates and classification, boundary
/// elements, values of all fields, and the model entities that the receiver needs. Links are found anew. A collective
/// call; `destinations` is emptied, to save memory.
///
/// Laws: the mesh as a whole is unchanged. The parts depend on the old parts and the destinations only: within a new
/// part the cells stand by old part, then in their old order, and vertices in the order in which cells use them.
/// Memory: the packets beside the cells' vertices, at the peak 1.41 times the mesh from 1 part to 16, and up to 1.7
/// times from 64 to 16,384; neighbours are dropped first and computed by the receiver.
///
/// Errors: InvalidArgument (a destination beyond `part_count`, a list of the wrong length), Cancelled, OutOfMemory.
/// After an error before the packets are complete, `mesh` is as it was, though its neighbours were computed anew. From
/// then on cancellation waits for the end.
MigrationFigures migrate(PartitionedMesh& mesh, PerPart<Destinations> destinations, std::size_t part_count,
                         const TaskRunner& runner, Trace* trace = nullptr);

}  // namespace tetloom
