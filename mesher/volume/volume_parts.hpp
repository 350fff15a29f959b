#pragma once
// A filled volume as the parts in which it was filled, never put together.
#include <array>
#include <cstdint>
#include <vector>

#include "mesher/volume/volume_mesher.hpp"
#include "tetloom/communicator.hpp"
#include "tetloom/growing_array.hpp"
#include "tetloom/tasks.hpp"

namespace tetloom {

/// Tets with vertices of their own. Numbers of points: those of the input below its number of points; then the new
/// ones, without gaps over all parts, the same in all parts that have them.
struct VolumePart {
  GrowingArray<Vec3> points;  ///< each in a tet; those of the input where they have become
  GrowingArray<std::uint64_t> vert_to_number;
  GrowingArray<std::uint32_t> tet_to_vert;  ///< 4 · tet; positive volume
  GrowingArray<std::uint32_t> tet_to_region;
  std::vector<std::uint32_t> triangles;                   ///< of the input that are faces of these tets, ascending
  std::vector<std::array<std::uint32_t, 3>> tri_to_vert;  ///< vertices here of each, as they have become
};

/// All parts of a volume that this rank has.
struct VolumeParts {
  std::vector<VolumePart> parts;  ///< those of each complex together, in the order of the complexes; of this rank
  std::size_t part_count = 0;     ///< on all ranks
  std::uint64_t new_points = 0;   ///< of the parts of all ranks
  std::vector<Diagnostic> errors, warnings;  ///< as of VolumeMesh
  FillingFigures figures;
};

/// As fill_volume, the same tets in parts: a complex that was filled in one part is one, and the numbers of all points
/// are those of fill_volume. A collective call, for which all ranks give the same; errors are the same on all of them.
VolumeParts fill_volume_in_parts(const VolumeInput& input, const VolumeOptions& options, Communicator& communicator,
                                 const TaskRunner& runner);

}  // namespace tetloom
