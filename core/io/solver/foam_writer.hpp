#pragma once
// OpenFOAM's polyMesh: a folder of files.
#include <filesystem>

#include "tetloom/host.hpp"
#include "tetloom/mesh_data.hpp"

namespace tetloom::detail {

/// Whether the path is a folder that OpenFOAM reads: a case ending in `.foam`, or a mesh called `polyMesh`.
bool is_foam_folder(const std::filesystem::path& path);

/// Whether it is a case.
bool is_foam_case(const std::filesystem::path& path);

/// Writes `points`, `faces`, `owner`, `neighbour`, `boundary`, `cellZones` and `faceZones`, all or none. Of a case,
/// they go to `constant/polyMesh`, and the dictionaries of `system` are made where there are none, so that checkMesh
/// runs.
///
/// Patches are the model's faces with cells on one side, in the order of their tags; boundary faces of cells that have
/// no triangle are the patch `no_face`. Regions are cell zones; faces between regions, and those inside of one, are
/// face zones. Faces are in upper-triangular order. A folder with files of somebody else is refused.
///
/// Errors: InvalidArgument (no cells, or too many to number with 31 bits), OutputFailed, Cancelled.
void write_foam(const Mesh& mesh, const std::filesystem::path& path, const CancelToken* cancel, const BlockLoop& loop);

// A case in parts: the mesh of part 3 lies in `processor3/constant/polyMesh`, see FoamMesh.

std::filesystem::path foam_part_folder(const std::filesystem::path& path, std::size_t part);

/// Makes the folders in which those of the parts will lie, and `system`, with a decomposeParDict of as many parts.
/// Errors: OutputFailed, also where the case has folders of more parts; Cancelled.
void prepare_foam_parts(const std::filesystem::path& path, std::size_t part_count, const CancelToken* cancel);

}  // namespace tetloom::detail
