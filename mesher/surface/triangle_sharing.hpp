#pragma once
// Shares the triangles of a patch out to pieces of a face. Private to the cutting of faces.
#include <cstdint>
#include <span>
#include <vector>

#include "mesher/surface/patch.hpp"

namespace tetloom {

/// The piece of every triangle, from 0 without gaps: at most `count`, about equal in weight, by bisection in space
/// across the longest side (Berger & Bokhari 1987), then with small islands and teeth of the borders given away. All
/// triangles at a place where the plane is singular (without a normal) are in one piece. Pre: the patch has no dead
/// slots; count >= 1.
std::vector<std::uint32_t> share_triangles(const Patch& patch, std::span<const double> weights, std::uint32_t count);

}  // namespace tetloom
