#pragma once
// Private to core/io/solver: what reader and writer of UGRID files share.
#include <algorithm>
#include <array>
#include <cstdint>
#include <tuple>

#include "core/io/formats_detail.hpp"

namespace tetloom::detail {

/// Binary files are streams of 64-bit reals and 32-bit integers.
enum class UgridForm : std::uint8_t { Text, LittleEndian, BigEndian };

/// The blocks of elements in the order of the file, whose counts stand behind that of the points. The entities of
/// triangles and quadrilaterals stand between quadrilaterals and tets.
inline constexpr std::array<Block, 6> kUgridBlocks{Block::Triangle, Block::Quad,  Block::Tet,
                                                   Block::Pyramid,  Block::Prism, Block::Hex};

/// The vertices of an element in the order of the file, which is another one for pyramids, here seen from the apex:
///
///     4---3  UGRID, the apex is 2      3---2  Mesh, the apex is 4
///     |   |                            |   |
///     1---0                            0---1
///
template <class Element>
Element in_ugrid_order(Element verts) {
  if constexpr (std::tuple_size_v<Element> == 5) return {verts[1], verts[0], verts[4], verts[2], verts[3]};
  return verts;
}

/// The inverse.
template <class Element>
Element out_of_ugrid_order(Element verts) {
  if constexpr (std::tuple_size_v<Element> == 5) return {verts[1], verts[0], verts[3], verts[4], verts[2]};
  return verts;
}

/// A triangle or quadrilateral seen from its other side: those of files point into the domain.
template <class Element>
Element turned_over(Element verts) {
  std::reverse(verts.begin() + 1, verts.end());
  return verts;
}

}  // namespace tetloom::detail
