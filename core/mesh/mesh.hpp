#pragma once
// An unstructured mesh in one piece, with the classification of everything in it on the geometric model.
#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "core/base/ids.hpp"
#include "core/base/vec.hpp"
#include "core/geometry/model.hpp"

namespace tetloom {

/// Names and colours of the model entities that a mesh refers to, kept apart from the model so that a mesh can be
/// written, read and checked without one. Indexed [dimension][entity index]; may be empty.
using EntityTable = std::array<std::vector<EntityAttributes>, 4>;

/// A struct of arrays. Each `x_to_entity` array is as long as its `x_to_vert`.
struct Mesh {
  std::vector<Vec3> points;
  std::vector<ModelEntity> point_to_entity;  ///< the lowest-dimension model entity that the point lies on; may be
                                             ///< invalid for meshes from elsewhere
  std::vector<std::array<std::uint32_t, 2>> edge_to_vert;  ///< pieces of model edges
  std::vector<std::uint32_t> edge_to_entity;               ///< index of the model edge
  std::vector<std::array<std::uint32_t, 3>> tri_to_vert;   ///< counter-clockwise seen from the tip of the face's normal
  std::vector<std::uint32_t> tri_to_entity;                ///< index of the model face
  std::vector<std::array<std::uint32_t, 4>> tet_to_vert;   ///< positive volume: dot(cross(b-a, c-a), d-a) > 0
  std::vector<std::uint32_t> tet_to_entity;                ///< index of the model region
  std::vector<FaceSides> face_to_sides;                    ///< per model face; empty when unknown
  EntityTable entities;
};

}  // namespace tetloom
