#pragma once
// From what ranks send of some tets to the tiles that these become at home.
#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "adapt/metric/background_place.hpp"
#include "adapt/metric/tile.hpp"
#include "tetloom/tasks.hpp"

namespace tetloom::adapt {

using FourVerts = std::array<std::uint32_t, 4>;
using FourFaces = std::array<BackgroundFace, 4>;

/// Consecutive names of tets, from the first of a tile on.
struct NameRange {
  BackgroundTet first = 0;  ///< of tile 0
  BackgroundTet begin = 0, end = 0;
};

/// What there is at the vertices and tets of tiles.
struct TileContents {
  bool has_metric = false;
  std::size_t components = 0;       ///< of all fields on points
  std::size_t cell_components = 0;  ///< of all fields on tets
  bool has_slopes = false;
};

/// The bytes of the tiles of `range`. `given`, from each rank: of its tets in there names, numbers in the mesh that was
/// given, vertices by their places in the message, links by names, and where there are fields on tets regions, values
/// and slopes; of these vertices numbers, points, logarithms of the metric and the implied metric, and fields. Vertices
/// of one number are one.
std::vector<Bytes> make_home_tiles(std::vector<Bytes>&& given, const NameRange& range, const TileContents& contents,
                                   const TaskRunner& runner);

}  // namespace tetloom::adapt
