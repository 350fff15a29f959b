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
struct RecoveredTets {
  std::vector<std::array<VertKey, 4>> made;  ///< tets inside, positive; new points by their index with kNewPoint
  std::vector<std::uint8_t> fixed;           ///< per made tet: which of its faces are of the surface
  std::vector<VertKey> keys;                 ///< of the other vertices in `made`, ascending
  std::vector<Vec3> points;                  ///< with these keys
  std::vector<Vec3> new_points;
};
inline constexpr VertKey kNewPoint = VertKey{1} << 63;

/// The tets by the parts that are to have them, ascending: as all tets of the shell, a tet belongs to the
/// part of its lowest vertex; tets at one new point go together.
std::vector<std::pair<PartId, RecoveredTets>> deal_recovered(const SharedInput& input, const RecoveredTets& tets);

void put(MessageWriter& writer, const RecoveredTets& tets);
RecoveredTets get_recovered(MessageReader& reader);

/// Puts tets into the mesh of their part. Returns how many sides of surface triangles they have.
std::size_t add_recovered(PartTets& tets, PartId part, const RecoveredTets& recovered, std::uint32_t region);

}  // namespace tetloom::parts
