#pragma once
// Cutting a polygon in space into triangles. Private to core/discrete.
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "tetloom/vec.hpp"

namespace tetloom::detail {

/// Triangles (indices into `corners`) of a simple polygon, of the polygon's orientation. Ear clipping in the plane of
/// Newell's normal, the best-shaped ear first; a polygon that is not simple is cut all the same, into corners - 2
/// triangles. Polygons of many corners take the first ear instead, convex ones of more than 64 are halved repeatedly.
/// Pre: at least 3 corners. Complexity: O(corners³) up to 128 corners, beyond that O(corners²) in practice.
std::vector<std::array<std::uint32_t, 3>> triangulate_polygon(std::span<const Vec3> corners);

}  // namespace tetloom::detail
