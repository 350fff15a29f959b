#pragma once
// Small features eliminated from one zone of a surface; see eliminate_features.hpp for what is done.
#include <cstdint>
#include <span>
#include <vector>

#include "mesher/features/zones.hpp"
#include "tetloom/tasks.hpp"

namespace tetloom::features {

/// What a zone becomes. Points keep their numbers; empty arrays where nothing was to be done.
struct ZoneChange {
  SurfaceItems items;                       ///< points as many as before, those that are gone as well
  std::vector<std::uint32_t> tri_source;    ///< per triangle, the one of the zone beside which it stands; ascending
  std::vector<std::uint32_t> piece_source;  ///< the same of pieces
  std::vector<std::uint32_t> now;           ///< per point, the one that it was merged into, or itself
  std::vector<double> moved;                ///< per point, the distance between the old and the new surface there
  std::vector<std::uint8_t> is_touched;     ///< per point: something was merged there
  std::vector<std::uint8_t> is_gone;        ///< per point: nothing uses it any more
  std::size_t collapses = 0, snaps = 0;

  bool is_empty() const { return collapses + snaps == 0; }
};

/// Starts at the zone's small triangles, the smallest first. Nothing is done at locked points. Errors: Cancelled.
ZoneChange eliminate_in_zone(const Zone& zone, std::span<const FaceSides> sides, const TaskRunner& runner);

}  // namespace tetloom::features
