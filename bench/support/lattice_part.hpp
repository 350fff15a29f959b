#pragma once
// Large meshes out of nothing: cubes of six tets each inside a solid, jittered, as one part.
#include <cstddef>
#include <string>

#include "tetloom/part_mesh.hpp"

namespace tetloom::bench {

/// About `tets` tets in "ball", "drilled-block" or "bracket" (an L with two holes), solids of a unit cube. Cubes whose
/// centre lies inside are divided alike by Kuhn's six tets; points inside move by up to a tenth of the cube's edge, by
/// a hash of their lattice place. Open faces are triangles of one model face. Throws std::invalid_argument for another
/// solid.
PartMesh make_lattice_part(const std::string& solid, double tets);

}  // namespace tetloom::bench
