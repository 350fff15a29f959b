#pragma once
// Whether this build is slowed down by a sanitizer, for tests that try as much as their time allows.

namespace tetloom::test {

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
constexpr bool kSanitized = true;
#else
constexpr bool kSanitized = false;
#endif

}  // namespace tetloom::test
