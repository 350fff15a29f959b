#pragma once
// The worker that a test is built with.

namespace tetloom::test {

/// Its path; empty where there is none.
#ifdef TETLOOM_WORKER
inline constexpr const char* kWorker = TETLOOM_WORKER;
#else
inline constexpr const char* kWorker = "";
#endif

}  // namespace tetloom::test
