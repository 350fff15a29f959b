#pragma once
// Mid nodes of layers: displaced like those of the wall below.
#include <vector>

#include "mesher/second_order/mid_node_places.hpp"

namespace tetloom::second_order {

/// Of the chord: what is farther away lies elsewhere on the model.
inline constexpr double kMostDisplacement = 0.5;

/// Above every mid node of `curved` that a prism has on the side of its wall, adds those of the edges that lie above
/// one another in layers: each displaced from the middle of its edge as the one on the wall, then, on a side face or
/// edge of the model, at the nearest place there. A layer between two triangles that are bent alike is as thick as a
/// straight one everywhere. `curved` ascends before and afterwards. Pre: mesh.mid_to_vert is there.
void carry_through_layers(const GeometricModel& model, const Mesh& mesh, std::vector<CurvedNode>& curved);

}  // namespace tetloom::second_order
