#pragma once
// What CGNS calls the kinds of elements, and in which order their nodes stand. Vertices have the order of a Mesh.
#include <array>
#include <cstdint>
#include <span>

#include "core/io/element_nodes_detail.hpp"

namespace tetloom::detail {

struct CgnsKind {
  const char* name;          ///< behind the name of a section
  std::int32_t type;         ///< ElementType_t
  std::int32_t second_type;  ///< of second order
};

inline constexpr std::array<CgnsKind, kBlocks> kCgnsKinds{{{"edge", 3, 4},
                                                           {"triangle", 5, 6},
                                                           {"quad", 7, 8},
                                                           {"tet", 10, 11},
                                                           {"pyramid", 12, 21},
                                                           {"prism", 14, 15},
                                                           {"hex", 17, 18}}};
inline constexpr std::int32_t kCgnsNode = 2, kCgnsMixed = 20;
inline constexpr std::size_t kCgnsNameBytes = 32;

constexpr const CgnsKind& cgns_kind(Block block) { return kCgnsKinds[static_cast<std::size_t>(block)]; }

inline constexpr std::array<LocalEdge, 9> kCgnsPrismEdges{
    {{0, 1}, {1, 2}, {2, 0}, {0, 3}, {1, 4}, {2, 5}, {3, 4}, {4, 5}, {5, 3}}};
inline constexpr std::array<LocalEdge, 12> kCgnsHexEdges{
    {{0, 1}, {1, 2}, {2, 3}, {3, 0}, {0, 4}, {1, 5}, {2, 6}, {3, 7}, {4, 5}, {5, 6}, {6, 7}, {7, 4}}};

/// The edges of an element in the order of its mid nodes.
constexpr std::span<const LocalEdge> cgns_edges_of(Block block) {
  if (block == Block::Prism) return kCgnsPrismEdges;
  if (block == Block::Hex) return kCgnsHexEdges;
  return edges_of(block);
}

}  // namespace tetloom::detail
