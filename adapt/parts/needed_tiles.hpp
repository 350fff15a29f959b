#pragma once
// Which tiles of the background parts are likely to ask for.
#include <cstdint>
#include <span>
#include <vector>

#include "adapt/metric/background_tiles.hpp"
#include "adapt/parts/cut_parts.hpp"
#include "tetloom/tasks.hpp"

namespace tetloom::adapt {

/// Those that have something where the tets of parts are, or a little beside. Ascending.
std::vector<std::uint32_t> needed_tiles(std::span<const PartOfWhole> parts, const BackgroundTiles& tiles,
                                        const TaskRunner& runner);

}  // namespace tetloom::adapt
