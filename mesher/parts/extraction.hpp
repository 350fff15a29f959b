#pragma once
// Which tets of a part go into strips.
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "mesher/parts/part_state.hpp"

namespace tetloom::parts {

/// The tets of a part that another one, or itself, takes into a strip; ascending.
struct ClaimedTets {
  PartId by;
  std::vector<std::uint32_t> tets;
};

/// The tets within two layers around the claimed vertices, each for the first part that claims it; ascending by
/// claimant. `claims`: vertices of open faces with who claims them, ascending; each vertex once.
std::vector<ClaimedTets> find_claimed_tets(const PartState& state,
                                           std::span<const std::pair<PartId, std::uint32_t>> claims);

}  // namespace tetloom::parts
