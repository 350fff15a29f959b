#pragma once
// Messages outside of schedules, where receivers do not know who will write to them.
#include <functional>
#include <vector>

#include "tetloom/communicator.hpp"

namespace tetloom {

/// Delivers every message to the rank that `rank_of` names for its destination, and returns those for this rank,
/// ascending by destination, then sender, then `step`. A collective call. Bytes are moved where they stay on the rank.
std::vector<Message> exchange(Communicator& communicator, std::vector<Message> outgoing,
                              const std::function<int(PartId)>& rank_of);

}  // namespace tetloom
