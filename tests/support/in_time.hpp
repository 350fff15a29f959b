#pragma once
// Tests of what has to happen in time, on machines that are busy with something else.
#include <functional>

namespace tetloom::test {

/// Repeats `run` until it returns true, which says that all of it came in time: a signal before the end of a run, an
/// end within its bound. False if that never happened. What must hold in any case is checked by `run` itself.
inline bool in_time(const std::function<bool()>& run) {
  for (int i = 0; i < 20; ++i)
    if (run()) return true;
  return false;
}

}  // namespace tetloom::test
