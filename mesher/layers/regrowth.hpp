#pragma once
// What stays as it was when layers are grown anew because some fans were taken back.
#include <cstdint>
#include <vector>

#include "mesher/layers/walls.hpp"

namespace tetloom::layers {

/// So many edges away from what has changed, curves stay: further than their directions are smoothed, and than the
/// slope of the thickness reaches where no layer is higher than wide.
inline constexpr int kRegrownRings = 10;

/// Per curve of `walls`, the same one of `before`; none where it has other triangles or another fan than there, or is
/// up to `rings` edges away from such a curve. Both are walls of one surface mesh, as were asked for alike.
std::vector<std::uint32_t> find_kept_curves(const Walls& walls, const Walls& before, int rings = kRegrownRings);

}  // namespace tetloom::layers
