#pragma once
// What the command's exit status says; other tools rely on these numbers.
#include <string_view>

#include "tetloom/error.hpp"

namespace tetloom::app {

/// How the command ends.
enum class ExitStatus {
  Done = 0,
  WrongUsage = 2,     ///< the command line, or a file with options, is wrong
  BadInput = 3,       ///< the input is unreadable or holds nothing that can be meshed
  NotMeshed = 4,      ///< the geometry cannot be meshed, or a mesh is not valid
  Cancelled = 5,      ///< by Ctrl-C or SIGTERM
  OutOfResources = 6  ///< memory or disk
};

ExitStatus exit_status(ErrorCode code);

/// "ok", "failed" or "cancelled", for the report.
std::string_view report_status(ExitStatus status);

}  // namespace tetloom::app
