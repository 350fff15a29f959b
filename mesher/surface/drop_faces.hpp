#pragma once
// Leaving model faces out of a surface mesh.
#include <vector>

#include "tetloom/mesh_data.hpp"

namespace tetloom {

/// Removes the triangles of the faces marked (by model face), then the pieces of model edges that are no side of a
/// triangle any more and the points that nothing uses. What stays keeps its order. Pre: no cells, no fields.
void drop_faces(const std::vector<bool>& marked, Mesh& mesh);

}  // namespace tetloom
