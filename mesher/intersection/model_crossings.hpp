#pragma once
// Do the faces of a model cross, or only the triangles that stand for them?
#include <span>
#include <vector>

#include "mesher/intersection/self_intersection.hpp"
#include "tetloom/mesh_data.hpp"
#include "tetloom/model.hpp"
#include "tetloom/tasks.hpp"

namespace tetloom {

/// Of the crossings of triangles, those that stand for a place where two faces of one region cross in the model itself,
/// which no size of triangles helps: a point that both surfaces have, where they make an angle, and which lies inside
/// both faces, clear of their edges; or facets of one or two faces that cross. One for each two faces, at most, in the
/// given order. What is not found may cross all the same, such as surfaces that touch. `surface` is the mesh that the
/// triangles are of. A few evaluations for each two faces, in parallel. Errors: Cancelled.
std::vector<TriangleIntersection> find_model_crossings(std::span<const TriangleIntersection> crossings,
                                                       const Mesh& surface, const GeometricModel& model,
                                                       const TaskRunner& runner);

}  // namespace tetloom
