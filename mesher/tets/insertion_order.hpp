#pragma once
#include <cstdint>
#include <span>
#include <vector>

#include "tetloom/vec.hpp"

namespace tetloom::tets {

/// `verts` in an order that is fast to insert in: rounds of growing size, each along a Hilbert curve through the box of
/// the points.
std::vector<std::uint32_t> make_insertion_order(std::span<const Vec3> points, std::span<const std::uint32_t> verts);

}  // namespace tetloom::tets
