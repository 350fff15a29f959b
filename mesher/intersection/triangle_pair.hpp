#pragma once
// The exact test of two triangles that may share vertices. Private to the mesher.
#include <array>
#include <cstdint>
#include <optional>
#include <span>

#include "mesher/intersection/self_intersection.hpp"
#include "tetloom/vec.hpp"

namespace tetloom::intersection {

/// A triangle by its three points.
using TriangleVertices = std::array<std::uint32_t, 3>;

/// True when the three points lie on a line, exactly.
bool is_degenerate(const Vec3& a, const Vec3& b, const Vec3& c);

/// How two triangles meet, and a point where they do.
struct PairVerdict {
  IntersectionKind kind;
  Vec3 point;
};

/// How the triangles meet beyond the vertices or the edge that they share by index; nothing when they do not.
/// Law: the same for either order of the triangles and any rotation of their vertices, up to `point`.
/// Pre: neither is degenerate. Follows the case analysis by shared vertices that mesh booleans use; own formulation.
std::optional<PairVerdict> check_pair(std::span<const Vec3> points, const TriangleVertices& first,
                                      const TriangleVertices& second);

}  // namespace tetloom::intersection
