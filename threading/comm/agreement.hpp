#pragma once
// One outcome for all ranks, where each has work of its own that may fail.
#include <functional>
#include <optional>

#include "tetloom/communicator.hpp"
#include "tetloom/error.hpp"

namespace tetloom {

/// Throws what the lowest rank gave that gave an error, on all ranks alike; returns when none did. A collective call.
void agree(Communicator& communicator, const std::optional<Diagnostic>& failure);

/// Calls `work`, which makes no collective calls, and agrees on what it threw: an Error as it is, lack of memory as
/// OutOfMemory, anything else as Internal. A collective call.
void run_on_all(Communicator& communicator, const std::function<void()>& work);

/// What `work` throws, in the same way.
std::optional<Diagnostic> failure_of(const std::function<void()>& work);

/// Calls `work` on rank 0 alone; errors as for run_on_all.
void run_on_first(Communicator& communicator, const std::function<void()>& work);

/// The number that rank 0 gives, on all ranks. A collective call.
std::uint64_t share_number(Communicator& communicator, std::uint64_t value);

}  // namespace tetloom
