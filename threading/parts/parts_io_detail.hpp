#pragma once
// Private to threading: one reader and one writer per format.
#include "tetloom/partition.hpp"
#include "tetloom/tasks.hpp"

namespace tetloom::detail {

void write_pieces(const PartitionedMesh& mesh, const std::filesystem::path& path, const TaskRunner& runner,
                  const CancelToken* cancel);
PartsAsTheyAre read_pieces(const std::filesystem::path& path, Communicator& communicator, const TaskRunner& runner,
                           const CancelToken* cancel);

void write_partitioned(const PartitionedMesh& mesh, const std::filesystem::path& path, const TaskRunner& runner,
                       const CancelToken* cancel);
void write_foam_parts(const PartitionedMesh& mesh, const std::filesystem::path& path, const TaskRunner& runner,
                      const CancelToken* cancel);
/// In one part where the file has none.
PartitionedMesh read_partitioned(const std::filesystem::path& path, Communicator& communicator,
                                 const TaskRunner& runner, const CancelToken* cancel);

}  // namespace tetloom::detail
