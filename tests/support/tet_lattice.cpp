#include "tests/support/tet_lattice.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace tetloom::test {

namespace {

constexpr std::uint32_t kNone = 0xffffffff;
using Corner = std::array<std::uint32_t, 3>;

constexpr std::array<std::array<int, 3>, 6> kPaths{{{0, 1, 2}, {0, 2, 1}, {1, 0, 2}, {1, 2, 0}, {2, 0, 1}, {2, 1, 0}}};

float jitter(std::uint32_t point, std::uint32_t axis) {
  std::uint64_t h = (std::uint64_t{point} * 3 + axis + 1) * 0x9e3779b97f4a7c15U;
  h = (h ^ (h >> 31)) * 0xbf58476d1ce4e5b9U;
  return 0.4F * (static_cast<float>(h >> 40) / static_cast<float>(1 << 24) - 0.5F);
}

/// The faces of all tets, matched by their sorted corners.
void link(TetLattice& lattice) {
  struct Face {
    std::array<std::uint32_t, 3> corners;
    std::uint32_t code;
  };
  std::vector<Face> faces;
  faces.reserve(lattice.tet_to_vert.size());
  for (std::uint32_t code = 0; code < lattice.tet_to_vert.size(); ++code) {
    Face face{{}, code};
    for (std::uint32_t i = 0, k = 0; i < 4; ++i)
      if (i != code % 4) face.corners[k++] = lattice.tet_to_vert[code / 4 * 4 + i];
    std::sort(face.corners.begin(), face.corners.end());
    faces.push_back(face);
  }
  std::sort(faces.begin(), faces.end(), [](const Face& a, const Face& b) { return a.corners < b.corners; });
  lattice.neighbours.assign(faces.size(), kNone);
  for (std::size_t i = 1; i < faces.size(); ++i)
    if (faces[i].corners == faces[i - 1].corners) {
      lattice.neighbours[faces[i].code] = faces[i - 1].code;
      lattice.neighbours[faces[i - 1].code] = faces[i].code;
    }
}

}  // namespace

bool in_ball(float x, float y, float z) { return std::hypot(x - 0.5F, y - 0.5F, z - 0.5F) < 0.5F; }
bool in_drilled_block(float x, float y, float z) {
  return y < 0.6F && z < 0.4F && std::hypot(x - 0.3F, y - 0.3F) > 0.15F && std::hypot(x - 0.75F, z - 0.2F) > 0.12F;
}
bool in_bracket(float x, float y, float z) { return y < 0.5F && (x < 0.2F || z < 0.2F); }

TetLattice make_tet_lattice(std::uint32_t cells, const Solid& solid) {
  TetLattice lattice;
  const std::uint32_t points = cells + 1;
  const float h = 1 / static_cast<float>(cells);
  lattice.vertex_count = std::size_t{points} * points * points;
  const auto add_tet = [&](Corner corner, const std::array<int, 3>& path) {
    std::array<float, 3> sum{};
    for (int i = 0; i < 4; ++i) {
      if (i > 0) ++corner[path[i - 1]];
      const std::uint32_t point = (corner[2] * points + corner[1]) * points + corner[0];
      lattice.tet_to_vert.push_back(point);
      for (std::uint32_t axis = 0; axis < 3; ++axis)
        sum[axis] += static_cast<float>(corner[axis]) + jitter(point, axis);
    }
    lattice.centroids.push_back({sum[0] * h / 4, sum[1] * h / 4, sum[2] * h / 4});
  };
  for (std::uint32_t k = 0; k < cells; ++k)
    for (std::uint32_t j = 0; j < cells; ++j)
      for (std::uint32_t i = 0; i < cells; ++i) {
        const auto at = [&](std::uint32_t index) { return (static_cast<float>(index) + 0.5F) * h; };
        if (!solid(at(i), at(j), at(k))) continue;
        for (const auto& path : kPaths) add_tet({i, j, k}, path);
      }
  link(lattice);
  return lattice;
}

}  // namespace tetloom::test
