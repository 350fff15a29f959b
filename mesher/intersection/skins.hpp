#pragma once
// Where the material of a model has no thickness.
#include <span>
#include <vector>

#include "mesher/intersection/self_intersection.hpp"
#include "mesher/intersection/triangle_tree.hpp"
#include "tetloom/mesh_data.hpp"
#include "threading/comm/shared_work.hpp"

namespace tetloom {

/// Pairs of triangles that face each other nearer than a tolerance with a region between them, as the floor of a hole
/// that lies in the outer face but for rounding: exact arithmetic tells them apart, the model's accuracy does not.
/// `face_to_tolerance`: how near, per model face; of two faces the larger counts. A pair is told where the centre of
/// one lies over the other, both are parallel to 1 degree, and they share no vertex: a wedge is none. Which of them the
/// region lies between is decided exactly. One pair for each triangle at most, sorted by (first, second), each once.
/// `tree`: of the surface. Complexity: as find_self_intersections. Errors: Cancelled.
std::vector<TriangleIntersection> find_skins(const Mesh& surface, std::span<const double> face_to_tolerance,
                                             const intersection::TriangleTree& tree, const SharedWork& work);

}  // namespace tetloom
