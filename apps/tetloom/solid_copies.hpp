#pragma once
// Solids of one shape: an assembly has many of each screw and each pin.
#include <vector>

#include "tetloom/model.hpp"

namespace tetloom::app {

/// The solids, and all others with as many faces, the same volume and the same area as one of them, to a millionth;
/// ascending. The solids alone where the model cannot tell.
std::vector<ModelRegionId> with_copies(const std::vector<ModelRegionId>& solids, const GeometricModel& model);

}  // namespace tetloom::app
