#pragma once
// What parts know of each other's borders in the end: the open faces of each, which have to fit together.
#include <cstdint>
#include <span>
#include <vector>

#include "mesher/parts/part_state.hpp"

namespace tetloom::parts {

/// Names the part's open faces by their vertices' keys, in the order of `open_faces`.
void name_open_faces(PartState& state);

/// Those of the names that a part of this box may have.
std::vector<std::uint64_t> open_faces_near(const PartState& state, const Box3& box);

/// Notes those of the part's open faces that no neighbour has told of; a fault where several have.
void check_open_faces(PartState& state, std::span<const std::span<const std::uint64_t>> told);

}  // namespace tetloom::parts
