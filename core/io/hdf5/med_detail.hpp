#pragma once
// What MED calls the kinds of elements, and in which order their nodes stand.
#include <array>
#include <cstdint>

#include "core/io/element_nodes_detail.hpp"

namespace tetloom::detail {

inline constexpr std::size_t kMedNameBytes = 80;  ///< of a group

/// Cells are mirrored: node k of MED is vertex `vert[k]` here. Mid nodes follow, those of the edges of `edges_of` with
/// the vertices in MED's order.
struct MedKind {
  const char* name;
  std::int32_t geometry;
  const char* second_name;  ///< of second order
  std::int32_t second_geometry;
  std::array<std::uint8_t, 8> vert;
};

inline constexpr std::array<MedKind, kBlocks> kMedKinds{{{"SE2", 102, "SE3", 103, {0, 1}},
                                                         {"TR3", 203, "TR6", 206, {0, 1, 2}},
                                                         {"QU4", 204, "QU8", 208, {0, 1, 2, 3}},
                                                         {"TE4", 304, "T10", 310, {0, 2, 1, 3}},
                                                         {"PY5", 305, "P13", 313, {0, 3, 2, 1, 4}},
                                                         {"PE6", 306, "P15", 315, {0, 2, 1, 3, 5, 4}},
                                                         {"HE8", 308, "H20", 320, {0, 3, 2, 1, 4, 7, 6, 5}}}};

constexpr const MedKind& med_kind(Block block) { return kMedKinds[static_cast<std::size_t>(block)]; }

}  // namespace tetloom::detail
