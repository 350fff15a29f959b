#pragma once
// Tests of what has to happen in time, on machines that are busy with something else.
#include <functional>
#include <optional>

namespace tetloom::test {

/// Repeats `run`, which tells whether all that had to come in time did (an end within its bound), and nothing where the
/// try tells nothing of that, because a signal came after the end of a run. True when at least half of the tries that
/// tell something kept their bound; there must be one. What must hold in any case is checked by `run` itself.
inline bool in_time(const std::function<std::optional<bool>()>& run) {
  constexpr int kTries = 20, kEnough = 3;
  int kept = 0, missed = 0;
  for (int i = 0; i < kTries && kept < kEnough && missed <= kEnough; ++i)
    if (const std::optional<bool> in_bound = run()) ++(*in_bound ? kept : missed);
  return kept > 0 && kept >= missed;
}

}  // namespace tetloom::test
