#pragma once
// The neighbourhoods of small triangles: a surface is changed in them, and stays as it is elsewhere. They share no
// point, so they are changed side by side, and one that is as it was before need not be changed anew.
#include <cstdint>
#include <span>
#include <vector>

#include "mesher/features/surface_complex.hpp"

namespace tetloom::features {

/// A piece of surface with what its change depends on.
struct Zone {
  SurfaceItems items;
  std::vector<double> tolerances, sizes;  ///< per point
  std::vector<std::uint8_t> is_locked;    ///< per point: it has to stay, and all at it
  std::vector<std::uint32_t> small;       ///< triangles at which the change begins, ascending
  bool operator==(const Zone&) const = default;
};

/// Numbers in the whole mesh of a zone's items, ascending: item i of the zone is `points[i]`, and so on.
struct ZoneItems {
  std::vector<std::uint32_t> points, triangles, pieces;
};

/// Zones, and per point of the mesh whether it lies so near the border of its zone that it has to stay.
struct Zones {
  std::vector<ZoneItems> items;              ///< by their lowest point
  std::vector<std::uint32_t> tri_to_zone;    ///< kNone: in none
  std::vector<std::uint32_t> piece_to_zone;  ///< kNone: in none
  std::vector<std::uint32_t> point_to_zone;  ///< kNone: in none
  std::vector<std::uint32_t> point_in_zone;  ///< the number of a point in its zone; of no meaning in none
  std::vector<std::uint8_t> is_near_border;
};

/// The triangles around `small` ones up to four edges away, each set that hangs together a zone. Points that may move
/// have all their triangles and pieces in the zone, and all their neighbours have all their triangles there. Linear.
Zones find_zones(const Mesh& mesh, std::span<const std::uint32_t> small);

/// The items of a zone, taken from the mesh.
SurfaceItems take_items(const Mesh& mesh, const ZoneItems& numbers, std::span<const std::uint32_t> point_in_zone);

/// Equal zones have equal numbers.
std::uint64_t hash(const Zone& zone);

}  // namespace tetloom::features
