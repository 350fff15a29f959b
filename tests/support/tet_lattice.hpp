#pragma once
// Meshes for tests and measurements of partitions: cubes cut into six tets each, jittered, inside a solid.
#include <cstdint>
#include <functional>
#include <vector>

#include "threading/balance/partitioners.hpp"

namespace tetloom::test {

struct TetLattice {
  std::vector<std::uint32_t> neighbours;   ///< tet · 4 + face codes
  std::vector<std::uint32_t> tet_to_vert;  ///< numbers of lattice points
  std::size_t vertex_count = 0;
  std::vector<Point3f> centroids;
};

/// A solid in the unit cube, as the set of cubes whose centres are inside.
using Solid = std::function<bool(float, float, float)>;
bool in_ball(float x, float y, float z);
bool in_drilled_block(float x, float y, float z);
bool in_bracket(float x, float y, float z);

/// Kuhn's division of each cube: all tets have the cube's main diagonal, so neighbouring cubes fit.
TetLattice make_tet_lattice(std::uint32_t cells_per_side, const Solid& solid);

}  // namespace tetloom::test
