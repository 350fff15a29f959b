#pragma once
// MSH files of a mesh in one piece that say to which part each cell belongs ($PartitionedEntities of MSH 4.1).
#include <cstdint>
#include <filesystem>
#include <vector>

#include "tetloom/host.hpp"
#include "tetloom/mesh_data.hpp"

namespace tetloom {

/// Which part of how many each cell belongs to.
struct MeshParts {
  std::uint32_t count = 0;                  ///< 0: the mesh is in no parts
  std::vector<std::uint32_t> cell_to_part;  ///< below count; cells as cell fields count them
};

/// Writes `mesh` as write_mesh does to .msh, with its parts: every model entity has a partitioned entity for each part
/// that it lies in. Boundary elements and points belong to the lowest part that has a cell with them.
/// Errors: those of write_mesh; InvalidArgument for parts that do not fit the cells.
void write_msh_parts(const Mesh& mesh, const MeshParts& parts, const std::filesystem::path& path,
                     const CancelToken* cancel = nullptr, const BlockLoop& loop = serial_loop());

/// Reads a mesh as read_mesh does, and its parts where the file has some. A cell on several partitions belongs to the
/// lowest of them. Errors: those of read_mesh; InputUnsuitable where only some cells are in parts.
Mesh read_msh_parts(const std::filesystem::path& path, MeshParts& parts, const CancelToken* cancel = nullptr);

/// Whether there is such a file with parts in it.
bool has_msh_parts(const std::filesystem::path& path, const CancelToken* cancel = nullptr);

}  // namespace tetloom
