#pragma once
// What the splits of edges inside of a part and at its sides have in common.
#include "adapt/kernel/cavity_mesh.hpp"

namespace tetloom::adapt {

/// Where the edge is split: in the middle of its length, or nearly a third of it where it is three times as long as it
/// should be. Sizes change geometrically on the way. The last bits depend on the order of a and b.
Vec3 place_of_split(const CavityMesh& mesh, std::uint32_t a, std::uint32_t b);

/// The cubed quality that all that is made has to be above. `floor`: the mean ratio that none should be below; `least`:
/// cubed quality of the worst tet at the edge.
double floor_of_split(double floor, double least);

/// What an edge lies on, of which `cavity` has all tets of the part.
PackedEntity entity_of_edge(const CavityMesh& mesh, const Cavity& cavity);

}  // namespace tetloom::adapt
