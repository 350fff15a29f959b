#pragma once
// The error that a call ends with.
#include <catch2/catch.hpp>

#include "tetloom/error.hpp"

namespace tetloom::test {

/// What `action` throws; the test fails when it throws no Error.
template <class Action>
Diagnostic error_of(const Action& action) {
  try {
    action();
  } catch (const Error& error) {
    return error.diagnostic();
  }
  FAIL("no error was thrown");
  return {};
}

}  // namespace tetloom::test
