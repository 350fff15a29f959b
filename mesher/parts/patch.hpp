#pragma once
// Tets that take the place of others where triangles of the surface have been recovered, on their way to the parts that
// are to have them.
#include <array>
#include <cstdint>
#include <utility>
#include <vector>

#include "mesher/parts/part_state.hpp"

namespace tetloom::parts {

/// Tets that take the place of others.
struct PatchTets {
  std::vector<std::array<VertKey, 4>> made;  ///< tets inside, positive; new points by their index with kNewPoint
  std::vector<std::uint8_t> fixed;           ///< per made tet: which of its faces are of the surface
  std::vector<VertKey> keys;                 ///< of the other vertices in `made`, ascending
  std::vector<Vec3> points;                  ///< with these keys
  std::vector<Vec3> new_points;
};
inline constexpr VertKey kNewPoint = VertKey{1} << 63;

/// The tets of a patch by the parts that are to have them, ascending: as all tets of the shell, a tet belongs to the
/// part of its lowest vertex; tets at one new point go together.
std::vector<std::pair<PartId, PatchTets>> deal_patch(const SharedInput& input, const PatchTets& patch);

void put(MessageWriter& writer, const PatchTets& patch);
PatchTets get_patch(MessageReader& reader);

/// Puts tets of a patch into their part's mesh, whose own ones have been joined.
void put_in_patch(PartState& state, PartId part, const PatchTets& patch, std::uint32_t region);

}  // namespace tetloom::parts
