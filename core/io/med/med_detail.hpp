#pragma once
// What MED calls the kinds of elements, and in which order their nodes stand.
#include <array>
#include <cstdint>

#include "core/io/formats_detail.hpp"

namespace tetloom::detail {

/// Cells are mirrored: node k of MED is vertex `vert[k]` here.
struct MedKind {
  const char* name;
  std::int32_t geometry;
  std::array<std::uint8_t, 8> vert;
};

inline constexpr std::array<MedKind, kBlocks> kMedKinds{{{"SE2", 102, {0, 1}},
                                                         {"TR3", 203, {0, 1, 2}},
                                                         {"QU4", 204, {0, 1, 2, 3}},
                                                         {"TE4", 304, {0, 2, 1, 3}},
                                                         {"PY5", 305, {0, 3, 2, 1, 4}},
                                                         {"PE6", 306, {0, 2, 1, 3, 5, 4}},
                                                         {"HE8", 308, {0, 3, 2, 1, 4, 7, 6, 5}}}};

constexpr const MedKind& med_kind(Block block) { return kMedKinds[static_cast<std::size_t>(block)]; }

}  // namespace tetloom::detail
