#pragma once
// Solids that interpenetrate: each is meshed on its own, and said to overlap.
#include <vector>

#include "core/base/error.hpp"
#include "core/geometry/model.hpp"
#include "core/mesh/mesh.hpp"
#include "threading/task_runner.hpp"

namespace tetloom {

/// A warning for every two regions of which one reaches into the other, with a face of the one and a point: a sample of
/// its surface, moved inwards by a quarter of the triangle's size, lies in the other. Solids that touch, and those that
/// overlap by less, are not told. At most 50 warnings. Errors: Cancelled. Complexity: a ray for up to 16 triangles of
/// every face.
std::vector<Diagnostic> find_overlapping_regions(const GeometricModel& model, const Mesh& surface,
                                                 const TaskRunner& runner);

}  // namespace tetloom
