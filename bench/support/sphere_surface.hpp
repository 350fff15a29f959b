#pragma once
// The unit sphere in triangles, for the benches of single steps.
#include <array>
#include <cstdint>
#include <vector>

#include "tetloom/vec.hpp"

namespace tetloom::bench {

/// Triangles are counter-clockwise seen from outside.
struct Sphere {
  std::vector<Vec3> points;
  std::vector<std::array<std::uint32_t, 3>> tri_to_vert;
};

/// An octahedron whose triangles are cut in four `levels` times.
Sphere make_sphere(int levels);

}  // namespace tetloom::bench
