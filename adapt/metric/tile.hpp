#pragma once
// A tile: a few hundred neighbouring tets of the mesh that adaptation starts from, with all that is looked up in them.
// Tiles are made once and never changed, so they may be sent to whoever needs them.
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "adapt/metric/background_place.hpp"
#include "adapt/metric/tet_links.hpp"
#include "tetloom/communicator.hpp"
#include "tetloom/metric.hpp"

namespace tetloom::adapt {

inline constexpr int kTileBits = 9;
/// Tets of a tile, but for the last ones of each rank. Larger tiles have fewer vertices twice, smaller ones fit parts
/// better.
inline constexpr std::uint32_t kTileTets = std::uint32_t{1} << kTileBits;
/// Faces of the boundary, and tets, that have one box in common.
inline constexpr std::uint32_t kFacesOfBox = 32, kTetsOfBox = 128;

/// Tets are named by their tile · kTileTets + their place in it, from the name of the first tile on (see
/// BackgroundTiles::Index). In a tile, names are short: by the tiles that it has links to. Non-owning; vertices are the
/// tile's own.
struct Tile {
  std::span<const Vec3> points;
  std::span<const Tensor> logs;     ///< of the metric, per vertex; none where there is a function, or
  std::span<const double> sizes;    ///< where all are a multiple of the identity: the factors
  std::span<const Tensor> implied;  ///< of the metric in which the mesh is unit; none once no stage needs it
  std::span<const double> fields;   ///< on points that are carried over, all components of a vertex side by side
  std::span<const std::array<std::uint16_t, 4>> to_vert;
  std::span<const std::array<FaceCode, 4>> links;  ///< as of link_tets; of tets place in `linked` · kTileTets + place
  std::span<const std::uint32_t> linked;           ///< tiles, ascending
  std::span<const std::uint64_t> numbers;          ///< of tets, by their places in the mesh that was given
  // Of tets, where fields on them are carried over.
  std::span<const std::uint32_t> regions;
  std::span<const double> cells;            ///< all components of a tet side by side
  std::span<const Vec3> slopes;             ///< as of limited_slopes; none where tets have constants
  std::span<const std::uint16_t> boundary;  ///< place · 4 + face of those with nothing behind

  /// The logarithm of the metric there, `place.tet` being the tet `tet` of the tile. Pre: there is a metric.
  Tensor log_metric_at(const BackgroundPlace& place, std::uint32_t tet) const {
    if (sizes.empty()) return mean_of_corners(logs, place, to_vert[tet]);
    double sum = place.weights[0] * sizes[to_vert[tet][0]];
    for (std::size_t i = 1; i < 4; ++i) sum += place.weights[i] * sizes[to_vert[tet][i]];
    return diagonal(sum, sum, sum);
  }

  /// What put_tile has put; valid as long as the bytes are.
  static Tile read(const Bytes& bytes);
  std::array<Vec3, 4> corners(std::uint32_t place) const {
    const auto& v = to_vert[place];
    return {points[v[0]], points[v[1]], points[v[2]], points[v[3]]};
  }
};

void put_tile(const Tile& tile, MessageWriter& writer);
/// The bytes of a tile.
Bytes bytes_of(const Tile& tile);

/// A box around some tets, or some faces of the boundary, of a tile.
struct TileBox {
  Box3 box;
  std::uint32_t tile = 0, first = 0;  ///< of kTetsOfBox places, or kFacesOfBox faces
};
/// Appends those of a tile.
void add_boxes(const Tile& tile, std::uint32_t number, std::vector<TileBox>& tets, std::vector<TileBox>& faces);

}  // namespace tetloom::adapt
