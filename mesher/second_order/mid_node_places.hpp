#pragma once
// Mid nodes on the curves and faces of the model, and those of layers above.
#include <vector>

#include "tetloom/mesh.hpp"
#include "tetloom/tasks.hpp"

namespace tetloom::second_order {

/// A mid node that does not lie in the middle between the ends of its edge.
struct CurvedNode {
  std::uint32_t mid = 0;          ///< its place in `Mesh::mid_to_vert`
  Vec3 place;                     ///< on the model, unless it lies inside of a region
  std::uint32_t follows = kNone;  ///< in layers, the mid node on the wall below; kNone: none
};

/// What became of mid nodes on the surface and in layers.
struct MidNodePlaces {
  std::vector<CurvedNode> curved;       ///< ascending
  std::vector<OffModelNode> off_model;  ///< those that stay in the middle although the model is elsewhere
};

/// Makes a mesh of first order one of second order: a mid node for every edge, classified on the model entity of lowest
/// dimension that the edge lies on; those on edges and faces of the model at the place of it that is nearest to the
/// middle of the chord. Where there is none within half the length of the chord they stay in the middle. Above the mid
/// node of an edge of a wall, those of the edges of its layers are displaced as it is. The result does not depend on
/// the number of threads. Errors: what the runner throws. Pre: require_consistent(mesh).
MidNodePlaces place_mid_nodes(const GeometricModel& model, Mesh& mesh, const TaskRunner& runner);

}  // namespace tetloom::second_order
