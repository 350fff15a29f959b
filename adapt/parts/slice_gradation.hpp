#pragma once
// How fast sizes may grow from vertex to vertex of a mesh in slices.
#include "adapt/parts/mesh_slice.hpp"
#include "threading/comm/shared_work.hpp"

namespace tetloom::adapt {

/// limit_gradation of the whole mesh: the same metric at all vertices, bit by bit, those of tets around the slice too.
/// In SharedWork::together; as many messages as rounds. Errors: as of metric.hpp.
void limit_gradation(MeshSlice& slice, double growth, const SharedWork& work);

}  // namespace tetloom::adapt
