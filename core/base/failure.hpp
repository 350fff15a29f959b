#pragma once
// What a call threw, as a value.
#include <cstddef>
#include <functional>
#include <optional>

#include "tetloom/error.hpp"

namespace tetloom {

/// Diagnostics of what many elements have in common name so many of them.
inline constexpr std::size_t kElementsToldAtMost = 100;

/// What `work` throws: an Error as it is, lack of memory as OutOfMemory, whatever else as Internal, with a message.
/// None where it throws nothing.
std::optional<Diagnostic> failure_of(const std::function<void()>& work);

}  // namespace tetloom
