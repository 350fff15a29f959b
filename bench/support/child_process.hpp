#pragma once
// Running another program and measuring it from outside.
#include <cstdint>
#include <string>
#include <vector>

namespace tetloom::bench {

struct ChildResult {
  int exit_status = -1;          ///< 128 + the signal's number when a signal ended it
  std::string output;            ///< standard output and standard error, as they came
  double seconds = 0;            ///< wall time from start to end
  double cpu_seconds = 0;        ///< user and system time of all its threads
  std::uint64_t peak_bytes = 0;  ///< largest resident set, of the program alone and not of what it starts
  std::uint64_t swap_bytes = 0;  ///< most memory that was swapped out whenever it was looked at
  bool timed_out = false;        ///< it was asked to end, or killed, because its time was up
};

/// How long a program may run; none: as long as it likes.
struct ChildLimit {
  double seconds = 0;  ///< then it and what it has started are asked to end (SIGINT); 0: no limit
  double grace = 10;   ///< seconds until they are killed
};

/// Runs `command` (a path or a name in PATH, then its arguments) and waits for it. Its standard input is empty. With a
/// limit it has a process group of its own.
/// Throws std::runtime_error when it cannot be started. Thread safety: may be called from any thread.
ChildResult run_child(const std::vector<std::string>& command, const ChildLimit& limit = {});

/// Whether a program of this name is in PATH.
bool is_installed(const std::string& program);

}  // namespace tetloom::bench
