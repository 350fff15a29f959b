#pragma once
// The surface improved where one part has all tets at it.
#include <cstdint>
#include <span>
#include <vector>

#include "mesher/parts/near_box.hpp"
#include "mesher/parts/part_state.hpp"
#include "tetloom/tasks.hpp"

namespace tetloom::parts {

/// As volume::improve, for the surface inside of the part: points stay that other parts have, too, that lie outside of
/// the part's box, or within two sizes of the box of a part with a lower number, which may change what lies across a
/// gap. `elsewhere`: points of the complex that other parts have. Vertices get new numbers. Returns the triangles that
/// have changed; what is done is counted in `report`.
std::vector<ChangedTriangle> improve_part(const SharedInput& input, PartTets& part_tets,
                                          std::span<const std::uint32_t> elsewhere, tets::OptimizeReport& report,
                                          PartId part, const TaskRunner& runner);

/// Whether the surface of a part whose tets have at least this quality is looked at.
bool wants_improvement(const SharedInput& input, double least_cubed);

/// The points of the surface that the part's tets have faces at, ascending, and those of any other part may have, too.
std::vector<Placed<std::uint32_t>> find_border_points(const SharedInput& input, const KeyedTets& part_tets,
                                                      PartId part);

}  // namespace tetloom::parts
