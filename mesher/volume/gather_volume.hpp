#pragma once
// A volume that was filled in parts, put together on the first rank.
#include "mesher/volume/volume_parts.hpp"
#include "tetloom/communicator.hpp"
#include "tetloom/mesh_data.hpp"
#include "tetloom/tasks.hpp"

namespace tetloom {

/// On the first rank, appends the tets of all parts to `mesh`, in the order of the parts, with their new points, which
/// are classified on their regions; points and triangles of the surface become what they are in the parts. Pre: `mesh`
/// holds the surface that was filled, and no tets. A collective call. `volume` is emptied. Errors: Cancelled,
/// OutOfMemory, on all ranks alike; `mesh` is of no use on the first one then.
void gather_volume(VolumeParts&& volume, Mesh& mesh, Communicator& communicator, const TaskRunner& runner);

}  // namespace tetloom
