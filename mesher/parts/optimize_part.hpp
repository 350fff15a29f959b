#pragma once
// A part's tets optimised, and looked at in the end.
#include <cstddef>
#include <span>
#include <vector>

#include "mesher/parts/part_state.hpp"
#include "tetloom/tasks.hpp"

namespace tetloom::parts {

/// Everything but what lies between parts. `open_faces`: of the core, which is the first `core_tets`.
tets::OptimizeReport optimize_inside(const SharedInput& input, PartTets& tets,
                                     std::span<const tets::FaceCode> open_faces, std::size_t core_tets, PartId part,
                                     const TaskRunner& runner);

/// The same for a strip; what is done is counted in `all`, and vertices inside of the strip wait no more.
void optimize_strip(const SharedInput& input, KeyedTets& strip, tets::OptimizeReport& all, const TaskRunner& runner);

/// What has become of a part's surface in the end, and whether all of its tets have volume.
struct FinishedSurface {
  std::vector<ChangedTriangle> changed_triangles;
  tets::Fault fault;
};

/// Drops dead tets, improves the surface where that is free and the tets need it, and takes the part's figures.
FinishedSurface finish_part(const SharedInput& input, PartTets& tets, const BorderCheck& check, FillingFigures& figures,
                            PartId part, const TaskRunner& runner);

}  // namespace tetloom::parts
