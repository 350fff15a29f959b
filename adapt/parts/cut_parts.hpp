#pragma once
// The parts of a rank's share of the mesh, to be changed but for what they share with others.
#include <cstdint>
#include <vector>

#include "adapt/parts/share.hpp"
#include "tetloom/tasks.hpp"

namespace tetloom::adapt {

/// Frozen are the vertices that others have too, here or on other ranks.
struct PartOfWhole {
  CavityMesh mesh;                       ///< to be started
  GrowingArray<std::uint32_t> to_whole;  ///< vertex of the share, of those that were there before
};

/// All that a part has, exactly, as it is.
void put_part(const PartOfWhole& part, MessageWriter& writer);
PartOfWhole get_part_of_whole(MessageReader& reader);

/// The parts `first`, `first` + 1 …, `count` of them, which are all that `share` has. Its mesh is given back array by
/// array as it goes over to them: what both need at once is a half more than the mesh alone.
std::vector<PartOfWhole> cut_parts(RoundShare& share, std::uint32_t first, std::uint32_t count,
                                   const TaskRunner& runner);

}  // namespace tetloom::adapt
