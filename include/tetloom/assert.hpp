#pragma once
// Assertions on tetloom's own invariants. A broken invariant is thrown as an Error of code Internal, because a library
// must never end its host. TETLOOM_ASSERT stays on in Release; TETLOOM_DEBUG_ASSERT does not.
namespace tetloom::detail {
[[noreturn]] void fail_assertion(const char* condition, const char* file, int line);
}

#define TETLOOM_ASSERT(condition) \
  ((condition) ? static_cast<void>(0) : ::tetloom::detail::fail_assertion(#condition, __FILE__, __LINE__))
#ifdef NDEBUG
#define TETLOOM_DEBUG_ASSERT(condition) static_cast<void>(0)
#else
#define TETLOOM_DEBUG_ASSERT(condition) TETLOOM_ASSERT(condition)
#endif
