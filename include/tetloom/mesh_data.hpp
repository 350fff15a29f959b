#pragma once
// Meshes as data: cells, and an unstructured mesh in one piece.
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "tetloom/ids.hpp"
#include "tetloom/model.hpp"
#include "tetloom/vec.hpp"

// The four kinds of volume cells: how many vertices, which faces, which edges.

namespace tetloom {

/// The order is that of the blocks in meshes and of the values in cell fields.
enum class CellKind : std::uint8_t { Tet, Pyramid, Prism, Hex };
constexpr std::size_t kCellKinds = 4;
constexpr std::array<CellKind, kCellKinds> kAllCellKinds{CellKind::Tet, CellKind::Pyramid, CellKind::Prism,
                                                         CellKind::Hex};
constexpr std::size_t kMaxCellVertices = 8;

/// Vertices of a face of a cell, counter-clockwise seen from outside the cell.
struct LocalFace {
  std::array<std::uint8_t, 4> vert;
  std::uint8_t count;
  constexpr std::span<const std::uint8_t> vertices() const { return {vert.data(), count}; }
};

///     Tet            Pyramid            Prism             Hex
///      3                4             3-------5        7-------6
///     /|\             /|\\            |\     /|       /|      /|
///    / | \           / | \ \          |  \ /  |      4-------5 |
///   0--|--2         /  3-----2        |   4   |      | 3-----|-2
///    \ | /         / /    \ /         0---|---2      |/      |/
///      1          0--------1            \ 1 /        0-------1
///
/// Positive orientation: the first face (0,1,2 or 0,1,2,3) is counter-clockwise seen from the vertices that follow it,
/// as in CGNS and Gmsh. Face i of a tet is opposite to its vertex i.
struct CellShape {
  std::uint8_t vertex_count, face_count, edge_count;
  std::array<LocalFace, 6> face;
  std::array<std::array<std::uint8_t, 2>, 12> edge;
  constexpr std::span<const LocalFace> faces() const { return {face.data(), face_count}; }
  constexpr std::span<const std::array<std::uint8_t, 2>> edges() const { return {edge.data(), edge_count}; }
};

constexpr std::array<CellShape, kCellKinds> kCellShapes{{
    {4,
     4,
     6,
     {{{{1, 2, 3, 0}, 3}, {{0, 3, 2, 0}, 3}, {{0, 1, 3, 0}, 3}, {{0, 2, 1, 0}, 3}}},
     {{{0, 1}, {1, 2}, {2, 0}, {0, 3}, {1, 3}, {2, 3}}}},
    {5,
     5,
     8,
     {{{{0, 3, 2, 1}, 4}, {{0, 1, 4, 0}, 3}, {{1, 2, 4, 0}, 3}, {{2, 3, 4, 0}, 3}, {{3, 0, 4, 0}, 3}}},
     {{{0, 1}, {1, 2}, {2, 3}, {3, 0}, {0, 4}, {1, 4}, {2, 4}, {3, 4}}}},
    {6,
     5,
     9,
     {{{{0, 2, 1, 0}, 3}, {{3, 4, 5, 0}, 3}, {{0, 1, 4, 3}, 4}, {{1, 2, 5, 4}, 4}, {{2, 0, 3, 5}, 4}}},
     {{{0, 1}, {1, 2}, {2, 0}, {3, 4}, {4, 5}, {5, 3}, {0, 3}, {1, 4}, {2, 5}}}},
    {8,
     6,
     12,
     {{{{0, 3, 2, 1}, 4},
       {{4, 5, 6, 7}, 4},
       {{0, 1, 5, 4}, 4},
       {{1, 2, 6, 5}, 4},
       {{2, 3, 7, 6}, 4},
       {{3, 0, 4, 7}, 4}}},
     {{{0, 1}, {1, 2}, {2, 3}, {3, 0}, {4, 5}, {5, 6}, {6, 7}, {7, 4}, {0, 4}, {1, 5}, {2, 6}, {3, 7}}}},
}};

constexpr const CellShape& shape_of(CellKind kind) { return kCellShapes[static_cast<std::size_t>(kind)]; }

/// "tet", "pyramid", "prism", "hex".
constexpr std::string_view to_string(CellKind kind) {
  constexpr std::array<std::string_view, kCellKinds> names{"tet", "pyramid", "prism", "hex"};
  return names[static_cast<std::size_t>(kind)];
}

/// A vertex of a cell and the three that edges join to it, in the order in which a positive cell gives a positive tet:
/// the sign of the Jacobian at that corner.
using CellCorner = std::array<std::uint8_t, 4>;
constexpr std::array<CellCorner, 1> kTetCorners{{{0, 1, 2, 3}}};
constexpr std::array<CellCorner, 4> kPyramidCorners{{{0, 1, 3, 4}, {1, 2, 0, 4}, {2, 3, 1, 4}, {3, 0, 2, 4}}};
constexpr std::array<CellCorner, 6> kPrismCorners{
    {{0, 1, 2, 3}, {1, 2, 0, 4}, {2, 0, 1, 5}, {3, 5, 4, 0}, {4, 3, 5, 1}, {5, 4, 3, 2}}};
constexpr std::array<CellCorner, 8> kHexCorners{
    {{0, 1, 3, 4}, {1, 2, 0, 5}, {2, 3, 1, 6}, {3, 0, 2, 7}, {4, 7, 5, 0}, {5, 4, 6, 1}, {6, 5, 7, 2}, {7, 6, 4, 3}}};

/// One corner for a tet; the four at the base for a pyramid, where those at the apex would add nothing.
constexpr std::span<const CellCorner> corners_of(CellKind kind) {
  switch (kind) {
    case CellKind::Tet: return kTetCorners;
    case CellKind::Pyramid: return kPyramidCorners;
    case CellKind::Prism: return kPrismCorners;
    case CellKind::Hex: return kHexCorners;
  }
  return {};
}

// An unstructured mesh in one piece, with the classification of everything in it on the geometric model.

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
/// The vertices of a cell come in the order of tetloom/mesh_data.hpp, which is that of VTK_TETRA, VTK_PYRAMID and
/// VTK_HEXAHEDRON, and for prisms that of CGNS and Gmsh. VTK_WEDGE turns the other way: the normal of its triangle 0 1
/// 2 points out of the cell, that of a Mesh's prism into it, towards 3 4 5. So VTU files have the vertices 1 and 2 as
/// well as 4 and 5 of prisms exchanged. Positive volume means
///   tet      dot(cross(x1 - x0, x2 - x0), x3 - x0) > 0;
///   pyramid  the base 0 1 2 3 turns counter-clockwise seen from the apex 4;
///   prism    0 1 2 turn counter-clockwise seen from 3 4 5: dot(cross(x1 - x0, x2 - x0), x3 - x0) > 0;
///   hex      0 1 2 3 turn counter-clockwise seen from 4 5 6 7;
/// and, exactly, that the tets of `corners_of` are positive. That suffices for tets and is necessary, but not
/// sufficient, for the Jacobian of the others to be positive all over.
///
/// A mesh is of first or of second order. One of second order has a mid node for every edge of every element, as the
/// serendipity elements of 10 (tet), 13, 15 and 20 nodes have them. Mid nodes are the last of the points; elements name
/// their vertices alone.
struct Mesh {
  std::vector<Vec3> points;                  ///< vertices, then mid nodes
  std::vector<ModelEntity> point_to_entity;  ///< the lowest-dimension model entity that the point lies on; may be
                                             ///< invalid for meshes from elsewhere. Where small features were
                                             ///< eliminated a point may lie on several model edges, pieces of which
                                             ///< end there: it is classified on one of them
  std::vector<std::array<std::uint32_t, 2>> mid_to_vert;   ///< the ends, lower one first, of the edge of mid node i,
                                                           ///< which is point points.size() - mid_to_vert.size() + i;
                                                           ///< ascending. Empty: first order
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
  std::vector<MeshField> point_fields;   ///< one tuple per point, mid nodes as well
  std::vector<MeshField> cell_fields;    ///< one tuple per cell: all tets, then pyramids, prisms, hexahedra
  std::vector<FaceSides> face_to_sides;  ///< per model face; empty when unknown
  EntityTable entities;
};

}  // namespace tetloom
