#pragma once
// A volume that ranks have filled in parts, put together on the first of them.
#include "mesher/volume/volume_mesher.hpp"
#include "mesher/volume/volume_parts.hpp"
#include "tetloom/tasks.hpp"

namespace tetloom {

/// On the first rank what fill_over_given gives there, in the same order; on the others no points and no tets. Errors,
/// warnings and figures are those of `parts` on all ranks. Pre: `input` is what was filled. A collective call. Errors:
/// Cancelled, OutOfMemory, on all ranks alike.
VolumeMesh gather_volume(const VolumeInput& input, VolumeParts&& parts, Communicator& communicator,
                         const TaskRunner& runner);

}  // namespace tetloom
