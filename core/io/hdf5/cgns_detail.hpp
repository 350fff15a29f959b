#pragma once
// What CGNS calls the kinds of elements. Their vertices have the order of a Mesh, their mid nodes that of
// edges_up_first.
#include <array>
#include <cstdint>
#include <span>

#include "core/io/element_nodes_detail.hpp"

namespace tetloom::detail {

/// A kind of elements as CGNS has it.
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

}  // namespace tetloom::detail
