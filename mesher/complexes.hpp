#pragma once
// Which faces belong together: solids that share faces form one complex, sheets that share edges another.
#include <cstdint>
#include <vector>

#include "tetloom/model.hpp"

namespace tetloom {

/// The complex of every face, numbered from 0 in the order of their first faces. Two faces are in one complex when
/// they bound the same region, or when they bound none and share an edge. Different complexes may touch or overlap in
/// space without sharing anything.
std::vector<std::uint32_t> find_complexes(const ModelTopology& topology);

}  // namespace tetloom
