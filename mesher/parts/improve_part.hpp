#pragma once
// The surface improved where one part has all tets at it.
#include <cstdint>
#include <span>
#include <vector>

#include "mesher/parts/part_state.hpp"

namespace tetloom::parts {

/// As volume::improve, for the surface inside of the part: points stay that other parts have, too, or that lie within a
/// size of their boxes, where another part may change what lies across a gap. Vertices get new numbers.
void improve_part(const SharedInput& input, PartState& state, PartId part, const TaskRunner& runner);

/// The points of the surface that the part's tets have faces at, ascending.
std::vector<std::uint32_t> find_surface_points(const PartState& state);

/// Those of them that tets of a part of this box may have, too.
std::vector<std::uint32_t> surface_points_near(const SharedInput& input, std::span<const std::uint32_t> points,
                                               const Box3& box);

}  // namespace tetloom::parts
