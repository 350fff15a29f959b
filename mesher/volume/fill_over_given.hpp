#pragma once
// A volume mesh whose points begin with the given ones, as the mesh of a whole model has them.
#include "mesher/volume/volume_mesher.hpp"
#include "tetloom/tasks.hpp"

namespace tetloom {

/// As fill_volume, but `new_points` begins with the points of the input, whose places count for nothing where
/// `moved_points` tells other ones.
VolumeMesh fill_over_given(const VolumeInput& input, const VolumeOptions& options, const TaskRunner& runner);

}  // namespace tetloom
