#pragma once
// Which tetrahedra share a face.
#include <cstdint>
#include <vector>

#include "core/tets/tet_mesh.hpp"
#include "tetloom/host.hpp"
#include "tetloom/ids.hpp"
#include "tetloom/metric.hpp"

namespace tetloom::adapt {

using tets::FaceCode;
using tets::kFaceVerts;

/// Per tet and face, opposite to its vertex of the same place: the same face of the tet behind it, not valid where
/// there is none. Where three or more tets share a face, the two lowest are linked. Pre: fewer than 2^30 tets, indices
/// in range. Linear but for vertices that are the lowest of very many faces.
std::vector<FaceCode> link_tets(const TetView& mesh, const BlockLoop& loop = serial_loop());

}  // namespace tetloom::adapt
