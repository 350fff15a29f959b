#pragma once
// Memory that nobody uses and the process still has.

namespace tetloom {

/// Gives pages of the heap on which nothing lies back to the system, wherever they are; nothing where the system knows
/// no such call. For the ends of stages: what is asked for next has to be touched anew.
void give_back_free_memory() noexcept;

/// The same where several processes share the work: a machine that has many of them has no room for what each might
/// need again.
inline void give_back_where_shared(int processes) noexcept {
  if (processes > 1) give_back_free_memory();
}

/// From now on what is large goes back when it is freed, and not only at the ends of stages.
void return_freed_memory() noexcept;

}  // namespace tetloom
