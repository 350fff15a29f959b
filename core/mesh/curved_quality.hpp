#pragma once
// What is measured of cells of second order.
#include "tetloom/check.hpp"
#include "tetloom/host.hpp"
#include "tetloom/mesh_data.hpp"

namespace tetloom {

/// Of all cells; `straight_volume` is that of the cells with straight edges. Pre: require_consistent(mesh).
CurvedQuality measure_curved(const Mesh& mesh, double straight_volume, const BlockLoop& loop);

}  // namespace tetloom
