#pragma once
// The file of a trace, read back for a replay.
#include <filesystem>
#include <vector>

#include "tetloom/tasks.hpp"

namespace tetloom::bench {

/// What Trace::write wrote. Throws std::runtime_error for a file that cannot be read or is none of those.
std::vector<TaskRecord> read_trace(const std::filesystem::path& path);

}  // namespace tetloom::bench
