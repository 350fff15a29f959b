#pragma once
// The subcommands. Each runs to its end, prints, writes its report and says how it ended.
#include "apps/tetloom/exit_status.hpp"
#include "apps/tetloom/model_reading.hpp"
#include "apps/tetloom/options.hpp"
#include "tetloom/communicator.hpp"

namespace tetloom::app {

/// All are collective calls.
ExitStatus run_mesh(const MeshCommand& command, ModelReading& reading, Communicator& communicator);
ExitStatus run_info(const InfoCommand& command, Communicator& communicator);
ExitStatus run_check(const CheckCommand& command, Communicator& communicator);
ExitStatus run_partition(const PartitionCommand& command, Communicator& communicator);
ExitStatus run_adapt(const AdaptCommand& command, Communicator& communicator);

}  // namespace tetloom::app
