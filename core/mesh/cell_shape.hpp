#pragma once
// The four kinds of volume cells: how many vertices, which faces, which edges.
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>

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

}  // namespace tetloom
