#pragma once
// How far the triangles of a mesh lie from the model faces that they are classified on.
#include <cstddef>

#include "tetloom/mesh_data.hpp"
#include "tetloom/model.hpp"

namespace tetloom::bench {

/// The largest distance of a triangle's centre from its face's surface, beside the triangle's longest edge, over at
/// most `most` triangles, evenly chosen. 0 where no triangle is classified on a face of the model.
double surface_distance(const Mesh& mesh, const GeometricModel& model, std::size_t most = 5000);

}  // namespace tetloom::bench
