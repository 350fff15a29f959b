#pragma once
// A filled volume: the parts in which it was filled.
#include <cstdint>
#include <vector>

#include "tetloom/error.hpp"
#include "tetloom/filling.hpp"
#include "tetloom/part_mesh.hpp"

namespace tetloom {

/// All parts of a volume, or of one complex of it. A part is lean: points, each in a tet, with their global ids, tets
/// of positive volume with their regions, and the triangles of the input that are faces of these tets, ascending;
/// nothing is connected or classified yet. Points of the input are where they have become, and have their numbers there
/// as global ids; new ones follow each other without gaps over all parts, those of one complex behind the points of the
/// input. The entity of a triangle is its number in the input, and its vertices are in the order that they have there,
/// or as the triangle has become.
struct VolumeParts {
  std::vector<PartMesh> parts;       ///< those of each complex together, in the order of the complexes; of this rank
  std::size_t part_count = 0;        ///< on all ranks
  std::uint64_t first_new = 0;       ///< global id of the first new point of a volume
  std::uint64_t new_points = 0;      ///< of the parts of all ranks
  std::vector<Diagnostic> errors;    ///< regions that could not be filled, with faces and a point; others are filled
  std::vector<Diagnostic> warnings;  ///< regions that were filled, but not as well as asked
  FillingFigures figures;
};

}  // namespace tetloom
