#pragma once
// Polygons of directions.
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "tetloom/vec.hpp"

namespace tetloom::layers {

/// Triangles of nodes, counter-clockwise seen from outside of the sphere, and the least product d0 · (d1 × d2) of their
/// directions.
struct SphericalTriangulation {
  std::vector<std::array<std::uint32_t, 3>> triangles;
  double least = 1;
};

/// Of a polygon of directions of length 1, counter-clockwise, the triangulation whose least product is greatest
/// (dynamic programming, Klincsek 1980). Pre: three nodes at least. Time n³.
SphericalTriangulation triangulate_on_sphere(std::span<const Vec3> nodes);

}  // namespace tetloom::layers
