#pragma once
// Partitioned meshes in files:
//
//   .pvtu  a list of pieces, and beside it a folder of its stem with one <stem>_<part>.vtu for each part. ParaView
//   opens
//          it; every rank reads and writes the pieces of its own parts. Holds everything that a PartitionedMesh holds.
//   .msh   Gmsh 4.1 with $PartitionedEntities, in one file, which rank 0 reads and writes: it has to hold the mesh as a
//          whole. Global ids are the order of the nodes.
#include <filesystem>
#include <optional>

#include "core/base/error.hpp"
#include "core/base/progress.hpp"
#include "core/mesh/mesh.hpp"
#include "threading/partitioned_mesh.hpp"
#include "threading/task_runner.hpp"

namespace tetloom {

/// Whether `path` ends in .pvtu or .msh, in upper or lower case.
bool is_writable_parts_format(const std::filesystem::path& path);
/// Whether `path` ends in .pvtu: a file that read_parts reads and read_mesh does not.
bool is_piece_list(const std::filesystem::path& path);

/// Whether `path` is a list of pieces by its name, or an MSH file with partitions. A collective call.
bool is_partitioned_file(const std::filesystem::path& path, Communicator& communicator);

/// Writes `mesh`, completely or not at all: a file or a folder that is there already is replaced only when everything
/// has been written, and nothing half-written stays after an error. A folder with anything but pieces in it is not
/// replaced. A process that is killed leaves its temporaries, and the old files as they were; only between the renaming
/// of the folder and that of the list, two calls next to each other, the old list would stand beside new pieces.
///
/// A collective call; with the same mesh, it makes the same bytes on any number of ranks and threads. Errors, the same
/// on all ranks: InvalidArgument (unknown extension, field names that the format cannot hold), OutputFailed, Cancelled,
/// OutOfMemory.
void write_parts(const PartitionedMesh& mesh, const std::filesystem::path& path, const TaskRunner& runner,
                 const CancelToken* cancel = nullptr);

/// Reads what write_parts wrote, into as many parts, and links them; any other file that read_mesh reads becomes a mesh
/// in one part. Within a part, cells come in the order of the file and vertices by global id.
///
/// A collective call. Errors, the same on all ranks, with the file at fault and a point where there is one:
/// InputUnreadable (missing, truncated or damaged files, pieces of other sizes or with other fields than the list
/// says), InputUnsuitable (lists of others, without global ids; pieces that do not fit together as validate_parts and
/// the totals of the list see it; what make_part refuses), OutOfMemory, Cancelled.
PartitionedMesh read_parts(const std::filesystem::path& path, Communicator& communicator, const TaskRunner& runner,
                           const CancelToken* cancel = nullptr);

/// What a partitioned file holds, whether its pieces fit together or not.
struct PartsAsTheyAre {
  PartitionedMesh mesh;
  std::optional<Diagnostic> misfit;  ///< what does not fit, the same on all ranks; `mesh` is good for figures only then
};

/// The same for those who judge: pieces that do not fit together are no error.
PartsAsTheyAre read_parts_as_they_are(const std::filesystem::path& path, Communicator& communicator,
                                      const TaskRunner& runner, const CancelToken* cancel = nullptr);

}  // namespace tetloom
