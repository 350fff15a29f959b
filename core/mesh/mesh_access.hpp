#pragma once
// Small questions to a Mesh that everything which handles meshes asks.
#include <cstddef>

#include "core/mesh/mesh.hpp"

namespace tetloom {

/// Throws Error(InvalidArgument) when an array has the wrong length or an index is out of range. `point_to_entity` may
/// be empty, which stands for "all unknown". Linear; allocates nothing.
void require_consistent(const Mesh& mesh);

/// The entity of point `i`, invalid where unknown. Pre: i < mesh.points.size().
inline ModelEntity entity_of_point(const Mesh& mesh, std::size_t i) {
  return mesh.point_to_entity.empty() ? ModelEntity{} : mesh.point_to_entity[i];
}

}  // namespace tetloom
