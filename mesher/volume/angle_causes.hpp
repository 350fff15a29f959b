#pragma once
// What of the model is behind tets with small angles.
#include <array>
#include <cstdint>
#include <optional>
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

/// A warning, InputUnsuitable, where the surface forces dihedral angles below one degree, with the worst place and what
/// lies there. None where there are no such tets.
std::optional<Diagnostic> warn_of_flat_tets(const tets::OptimizeReport& report);

}  // namespace tetloom::volume
