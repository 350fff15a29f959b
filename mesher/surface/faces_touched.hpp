#pragma once
// Which faces have to be meshed again when sizes change.
#include <span>
#include <vector>

#include "mesher/surface/edge_mesher.hpp"
#include "mesher/surface/face_mesher.hpp"
#include "tetloom/tasks.hpp"

namespace tetloom {

/// Per face, whether one of the boxes overlaps its mesh or what lies beside it, as far as its longest edge. Pre: the
/// faces' rim nodes are those of `rim`. O((n + m) log m) for n changes and m faces, in parallel.
std::vector<bool> find_faces_touched(std::span<const Box3> changes, std::span<const FaceMesh> faces,
                                     const RimNodes& rim, const TaskRunner& runner);

}  // namespace tetloom
