#pragma once
// Whether tets have room above the layers.
#include <cstdint>
#include <span>
#include <vector>

#include "mesher/layers/layer_counts.hpp"
#include "mesher/layers/layered_surface.hpp"
#include "mesher/layers/walls.hpp"
#include "tetloom/tasks.hpp"

namespace tetloom::layers {

/// Per curve how much thinner its layers have to become, so that the gap between its top and what is opposite to it is
/// no narrower than half of the width of the front there; 0 where it is wide enough, or where the curve has one layer
/// or none. Two fronts opposite to each other share what is lacking. Of curves that are not `asked` for it is 0.
/// Errors: Cancelled.
std::vector<double> find_lacking_room(const Walls& walls, const LayerCounts& counts, const LayeredSurface& surface,
                                      std::span<const std::uint8_t> asked, const TaskRunner& runner);

}  // namespace tetloom::layers
