#pragma once
// Consecutive numbers for global ids, which may have gaps.
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "threading/comm/shared_work.hpp"

namespace tetloom {

/// The number of each of some ids, ascending and distinct: its place among those of all ranks. `count`: how many these
/// are. In SharedWork::together.
std::vector<std::uint64_t> number_ids(std::span<const std::uint64_t> ids, std::size_t& count, const SharedWork& work);

}  // namespace tetloom
