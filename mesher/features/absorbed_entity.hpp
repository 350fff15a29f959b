#pragma once
// A model entity that is too small for a mesh.
#include "core/base/ids.hpp"

namespace tetloom {

/// A model entity of which a mesh has nothing, because it was too small for the sizes.
struct AbsorbedEntity {
  ModelEntity entity;
  ModelEntity into;     ///< the entity on which the mesh now lies where it was
  double distance = 0;  ///< by which its points were moved, at most; model length
};

}  // namespace tetloom
