#pragma once
// What curved faces and edges of a model ask of the metric of a mesh in slices.
#include "adapt/parts/mesh_slice.hpp"
#include "threading/comm/shared_work.hpp"

namespace tetloom::adapt {

/// limit_by_curvature of the whole mesh: the same metric at all vertices, bit by bit, those of tets around the slice
/// too. Each face and edge of the model is looked at by one rank, which hears of all vertices there. In
/// SharedWork::together. Errors: as of metric.hpp.
void limit_by_curvature(MeshSlice& slice, const GeometricModel& model, const CurvatureLimits& limits,
                        const SharedWork& work);

}  // namespace tetloom::adapt
