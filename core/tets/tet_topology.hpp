#pragma once
// The one table of a tetrahedron's faces and edges; everything else about its corners follows from it.
//
//          3
//         /|\            Face i is opposite to corner i.
//        / | \           Edge k runs between the first two corners of kEdgeCorners[k]; the other two are those of the
//       0--|--2          opposite edge, which is edge 5 - k.
//        \ | /
//          1
#include <array>
#include <cstddef>
#include <cstdint>

#include "tetloom/mesh_data.hpp"

namespace tetloom::tets {

/// The corners of each face, counter-clockwise from outside, as for all cells.
inline constexpr std::array<std::array<std::uint8_t, 3>, 4> kFaceVerts = [] {
  std::array<std::array<std::uint8_t, 3>, 4> faces{};
  for (std::size_t face = 0; face < 4; ++face)
    for (std::size_t i = 0; i < 3; ++i) faces[face][i] = shape_of(CellKind::Tet).face[face].vert[i];
  return faces;
}();

/// The corners of each edge with the other two, in even permutations: a tet (a, b, c, d) in that order is positive.
inline constexpr std::array<std::array<std::uint8_t, 4>, 6> kEdgeCorners{
    {{0, 1, 2, 3}, {0, 2, 3, 1}, {0, 3, 1, 2}, {1, 2, 0, 3}, {1, 3, 2, 0}, {2, 3, 0, 1}}};

/// The corners of each edge alone, ascending.
inline constexpr std::array<std::array<std::uint8_t, 2>, 6> kEdgeVerts = [] {
  std::array<std::array<std::uint8_t, 2>, 6> edges{};
  for (std::size_t edge = 0; edge < 6; ++edge) edges[edge] = {kEdgeCorners[edge][0], kEdgeCorners[edge][1]};
  return edges;
}();

/// Of two different corners, the other two, ascending.
inline constexpr std::array<std::array<std::array<std::uint8_t, 2>, 4>, 4> kOtherCorners = [] {
  std::array<std::array<std::array<std::uint8_t, 2>, 4>, 4> others{};
  for (std::size_t edge = 0; edge < 6; ++edge) {
    const auto [a, b] = kEdgeVerts[edge];
    others[a][b] = others[b][a] = kEdgeVerts[5 - edge];
  }
  return others;
}();

/// Whether two different corners and the other two, ascending, are an even permutation.
inline constexpr std::array<std::array<bool, 4>, 4> kIsEven = [] {
  std::array<std::array<bool, 4>, 4> even{};
  for (const auto& [a, b, c, d] : kEdgeCorners) even[a][b] = c<d, even[b][a] = c> d;
  return even;
}();

}  // namespace tetloom::tets
