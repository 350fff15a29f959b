#pragma once
// One run of the worker executable as a child process: a frame goes in, a frame comes out.
//
// The child talks over a socket pair on its descriptors 0 and 1 (a socket, because writing to one can be asked not to
// raise SIGPIPE), inherits no other descriptor but its error output, which is kept for messages, and has a process
// group of its own, so that Ctrl-C at a terminal reaches the host alone. It is killed and reaped before the call
// returns, however the call ends. No signal disposition of the host is touched.
#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include "tetloom/tasks.hpp"

namespace tetloom::volume {

/// The worker to run: `wanted` where it is given, else tetloom-tetgen beside the running executable, in the libexec or
/// bin folder beside its folder, or in PATH.
/// Errors: WorkerFailed with what to do when there is none that can be executed.
std::string find_worker(const std::string& wanted);

/// How a run ended.
struct WorkerRun {
  std::vector<std::byte> response;  ///< a whole frame, its header checked and its payload not; empty when it failed
  std::string failure;              ///< how the child ended and what it last wrote to its error output
  bool crashed = false;             ///< a crash or assertion of its own: other input may fare better
};

/// Runs `worker` on one request frame.
/// Errors: Cancelled within about 50 ms of the host's wish; WorkerFailed when the child cannot be started or what it
/// sends is not a response. A child that ends without a whole response is told in the result.
/// Thread safety: any number of calls at once.
WorkerRun run_worker(const std::string& worker, std::span<const std::byte> request, const TaskRunner& runner);

}  // namespace tetloom::volume
