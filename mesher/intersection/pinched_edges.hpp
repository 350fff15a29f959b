#pragma once
// Where the faces of a surface mesh meet in an edge that is no piece of a model edge.
#include <vector>

#include "mesher/intersection/self_intersection.hpp"
#include "tetloom/mesh_data.hpp"
#include "threading/comm/shared_work.hpp"

namespace tetloom {

/// Edges between two vertices that are of model edges or vertices, that are themselves no piece of a model edge, and
/// that have more than two triangles, or two of different faces: strips that lie on each other between the same two
/// model edges have such, however exact arithmetic tells them apart. For each edge the first triangle with the first
/// one of another face, or with the next one where all are of one face, and the middle of the edge; ascending by
/// (first, second). Complexity: linear in the triangles, which the ranks deal among them, O(n log n) in those edges.
std::vector<TriangleIntersection> find_pinched_edges(const Mesh& surface, const SharedWork& work);

}  // namespace tetloom
