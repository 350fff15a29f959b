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

/// Numbers that hang on the points or the cells of a mesh: `components` doubles for each, one after the other. They may
/// be infinite or NaN; NaN stands for "no value here".
struct MeshField {
  std::string name;  ///< not empty, and no other field on the same kind of carrier has it
  int components = 1;
  std::vector<double> values;
};

/// A struct of arrays. Each `x_to_entity` array is as long as its `x_to_vert`.
///
/// The vertices of a cell come in the order of core/mesh/cell_shape.hpp, which is that of VTK_TETRA, VTK_PYRAMID and
/// VTK_HEXAHEDRON, and for prisms that of CGNS and Gmsh. VTK_WEDGE turns the other way: the normal of its triangle 0 1
/// 2 points out of the cell, that of a Mesh's prism into it, towards 3 4 5. So VTU files have the vertices 1 and 2 as
/// well as 4 and 5 of prisms exchanged. Positive volume means
///   tet      dot(cross(x1 - x0, x2 - x0), x3 - x0) > 0;
///   pyramid  the base 0 1 2 3 turns counter-clockwise seen from the apex 4;
///   prism    0 1 2 turn counter-clockwise seen from 3 4 5: dot(cross(x1 - x0, x2 - x0), x3 - x0) > 0;
///   hex      0 1 2 3 turn counter-clockwise seen from 4 5 6 7;
/// and, exactly, that the tets of `corners_of` are positive. That suffices for tets and is necessary, but not
/// sufficient, for the Jacobian of the others to be positive all over.
struct Mesh {
  std::vector<Vec3> points;
  std::vector<ModelEntity> point_to_entity;  ///< the lowest-dimension model entity that the point lies on; may be
                                             ///< invalid for meshes from elsewhere. Where small features were
                                             ///< eliminated a point may lie on several model edges, pieces of which
                                             ///< end there: it is classified on one of them
  std::vector<std::array<std::uint32_t, 2>> edge_to_vert;  ///< pieces of model edges
  std::vector<std::uint32_t> edge_to_entity;               ///< index of the model edge
  std::vector<std::array<std::uint32_t, 3>> tri_to_vert;   ///< counter-clockwise seen from the tip of the face's normal
  std::vector<std::uint32_t> tri_to_entity;                ///< index of the model face
  std::vector<std::array<std::uint32_t, 4>> quad_to_vert;  ///< quadrilaterals, in a cycle, seen as triangles are
  std::vector<std::uint32_t> quad_to_entity;               ///< index of the model face
  std::vector<std::array<std::uint32_t, 4>> tet_to_vert;   ///< positive volume, as all cells
  std::vector<std::uint32_t> tet_to_entity;                ///< index of the model region
  std::vector<std::array<std::uint32_t, 5>> pyramid_to_vert;
  std::vector<std::uint32_t> pyramid_to_entity;  ///< index of the model region, as for the next two
  std::vector<std::array<std::uint32_t, 6>> prism_to_vert;
  std::vector<std::uint32_t> prism_to_entity;
  std::vector<std::array<std::uint32_t, 8>> hex_to_vert;
  std::vector<std::uint32_t> hex_to_entity;
  std::vector<MeshField> point_fields;   ///< one tuple per point
  std::vector<MeshField> cell_fields;    ///< one tuple per cell: all tets, then pyramids, prisms, hexahedra
  std::vector<FaceSides> face_to_sides;  ///< per model face; empty when unknown
  EntityTable entities;
};

}  // namespace tetloom
