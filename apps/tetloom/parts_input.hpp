#pragma once
// Partitioned files, for the commands that look at a mesh as a whole.
#include <filesystem>
#include <optional>

#include "apps/tetloom/run.hpp"
#include "tetloom/mesh_data.hpp"
#include "tetloom/partition.hpp"
#include "tetloom/tasks.hpp"

namespace tetloom::app {

/// A mesh in parts, brought together.
struct WholeOfParts {
  Mesh mesh;  ///< on the first rank; empty where there is a misfit
  PartsFigures figures;
  std::optional<Diagnostic> misfit;  ///< what does not fit between the pieces, the same on all ranks
};

/// Reads a partitioned file, with all links checked, and brings its parts together; nothing for any other file, which
/// is not read then. Notes the parts in the report. A collective call.
std::optional<WholeOfParts> read_whole_of_parts(const std::filesystem::path& input, Communicator& communicator,
                                                const TaskRunner& runner, Run& run);

}  // namespace tetloom::app
