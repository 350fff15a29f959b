#pragma once
// Which tetrahedra share a face.
#include <cstdint>
#include <vector>

#include "adapt/metric/vertex_graph.hpp"
#include "core/base/block_loop.hpp"
#include "core/base/ids.hpp"

namespace tetloom::adapt {

/// Per tet and face, opposite to its vertex of the same place: the same face of the tet behind it as tet · 4 + face,
/// kNone where there is none. Where three or more tets share a face, the two lowest are linked. Pre: fewer than 2^30
/// tets, indices in range. Linear but for vertices that are the lowest of very many faces.
std::vector<std::uint32_t> link_tets(const TetView& mesh, const BlockLoop& loop = serial_loop());

/// Face `i` of a tet is opposite to its vertex `i`: its vertices, counter-clockwise seen from outside.
inline constexpr std::array<std::array<std::uint8_t, 3>, 4> kFaceVerts{{{1, 2, 3}, {0, 3, 2}, {0, 1, 3}, {0, 2, 1}}};

}  // namespace tetloom::adapt
