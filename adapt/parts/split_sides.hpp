#pragma once
// Edges that several parts have, split by all of them alike before each is changed on its own.
#include <span>

#include "adapt/kernel/side_splits.hpp"
#include "adapt/parts/cut_parts.hpp"
#include "adapt/parts/rounds.hpp"
#include "threading/comm/shared_work.hpp"

namespace tetloom::adapt {

/// Sweep after sweep the parts name edges, one exchange tells which of them none refuses, and each part splits these.
/// New vertices are shared ones of `share` from then on. Returns how many edges were split, each of them counted on one
/// rank. The result depends on the parts alone. In SharedWork::together.
std::size_t split_sides(RoundShare& share, const ShareLinks& links, std::span<PartOfWhole> parts,
                        const RoundWork& round, const SharedWork& work);

}  // namespace tetloom::adapt
