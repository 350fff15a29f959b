#pragma once
// The metric of a solution on a mesh in slices.
#include <string>

#include "adapt/parts/mesh_slice.hpp"
#include "threading/comm/shared_work.hpp"

namespace tetloom::adapt {

/// metric_from_solution of the whole mesh: the same metric at all vertices of own tets, bit by bit. `field`: of one
/// component, on the points of the slice. Ranks ask each other for what lies within three edges of own vertices, for as
/// long as second derivatives are sought. In SharedWork::together. Errors: as of metric.hpp, without elements.
HessianMetric metric_from_solution(const MeshSlice& slice, const std::string& field, const HessianOptions& options,
                                   const SharedWork& work);

}  // namespace tetloom::adapt
