#pragma once
// What of the model is behind tets with small angles.
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "mesher/tets/acute_tets.hpp"
#include "mesher/volume/complex.hpp"
#include "mesher/volume/volume_mesher.hpp"

namespace tetloom::volume {

/// Gives the tets their entities, and turns the vertices of the complex that they name into those of the input.
/// `tri_to_vert`: the complex's triangles as they have become.
void name_causes(const VolumeInput& input, const Complex& complex,
                 std::span<const std::array<std::uint32_t, 3>> tri_to_vert, std::vector<AcuteTet>& tets);

}  // namespace tetloom::volume
