#pragma once
// Which tets of a part go into strips.
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "mesher/parts/part_state.hpp"

namespace tetloom::parts {

/// The tets of a part that migrate to another one, or stay, in a strip; ascending.
struct TetsToMigrate {
  PartId to;
  std::vector<std::uint32_t> tets;
};

/// The tets within two layers around the vertices, each for the first of their owners; ascending by destination.
/// `verts`: vertices of open faces with their owners, ascending; each vertex once. `strips` has these faces.
std::vector<TetsToMigrate> find_tets_to_migrate(const tets::TetMesh& mesh, const StripState& strips,
                                                std::span<const std::pair<PartId, std::uint32_t>> verts);

}  // namespace tetloom::parts
