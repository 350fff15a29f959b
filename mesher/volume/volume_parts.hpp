#pragma once
// A filled volume: the parts in which it was filled.
#include <array>
#include <cstdint>
#include <vector>

#include "tetloom/error.hpp"
#include "tetloom/filling.hpp"
#include "tetloom/growing_array.hpp"
#include "tetloom/vec.hpp"

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

/// All parts of a volume, or of one complex of it.
struct VolumeParts {
  std::vector<VolumePart> parts;     ///< those of each complex together, in the order of the complexes; of this rank
  std::size_t part_count = 0;        ///< on all ranks
  std::uint64_t new_points = 0;      ///< of the parts of all ranks
  std::vector<Diagnostic> errors;    ///< regions that could not be filled, with faces and a point; others are filled
  std::vector<Diagnostic> warnings;  ///< regions that were filled, but not as well as asked
  FillingFigures figures;
};

}  // namespace tetloom
