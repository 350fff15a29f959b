#pragma once
// The subcommands. Each runs to its end, prints, writes its report and says how it ended.
#include "apps/tetloom/exit_status.hpp"
#include "apps/tetloom/options.hpp"

namespace tetloom::app {

ExitStatus run_mesh(const MeshCommand& command);
ExitStatus run_info(const InfoCommand& command);
ExitStatus run_check(const CheckCommand& command);

}  // namespace tetloom::app
