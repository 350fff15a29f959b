#pragma once
// The mesh that adaptation starts from, spread over ranks in tiles. A rank has the tiles that it is the *home* of, and
// meanwhile those that its parts need.
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <span>
#include <vector>

#include "adapt/metric/background_place.hpp"
#include "adapt/metric/tile.hpp"
#include "core/base/fixed_array.hpp"
#include "core/spatial/bvh.hpp"
#include "tetloom/metric.hpp"
#include "threading/comm/shared_work.hpp"

namespace tetloom::adapt {

/// A tile was asked for that is not at hand. No error: see BackgroundTiles::until_found.
struct MissingTile {
  std::uint32_t tile;
};

/// What needs a tile, by a number of its own.
struct TileUse {
  std::uint32_t tile, number;
  auto operator<=>(const TileUse&) const = default;
};

/// Places and metrics are those that the whole mesh would give, bit by bit: what is not at hand is not guessed at but
/// asked for. So which tiles are at hand decides about time alone.
///
/// Thread safety: any number of threads may look up; what fetches or drops is for one at a time.
class BackgroundTiles {
 public:
  /// Which tiles there are. The same on all ranks but for `own`.
  struct Index {
    BackgroundTet first_name = 0;            ///< of tile 0
    std::vector<std::uint32_t> first_tiles;  ///< of each rank, and how many there are
    std::size_t tet_count = 0;
    std::vector<TileBox> tets, faces;  ///< of all tiles
  };
  /// `own`: the bytes of the tiles at home here.
  BackgroundTiles(std::vector<Bytes>&& own, Index&& index, int rank, const TaskRunner& runner);

  /// The boxes of all tiles, which all ranks have, are where `keep` keeps them from now on.
  void move_boxes(const KeepBytes& keep);

  // What BackgroundSearch asks for. Where a tile is missing, Pausable work waits for it, and else MissingTile is
  // thrown.

  std::size_t tet_count() const { return index_.tet_count; }
  std::array<Vec3, 4> corners(BackgroundTet tet) const { return tile_with(tet).corners(place_in_tile(tet)); }
  BackgroundFace behind(BackgroundFace face) const {
    const Tile& tile = tile_with(face.tet());
    const FaceCode link = tile.links[place_in_tile(face.tet())][face.side()];
    if (!link.valid()) return {};
    return {name_of(tile.linked[link.tet() / kTileTets], link.tet() % kTileTets), link.side()};
  }
  std::uint64_t number(BackgroundTet tet) const { return tile_with(tet).numbers[place_in_tile(tet)]; }
  NearestOnBoundary nearest(const Vec3& x) const;

  Tensor log_metric_at(const BackgroundPlace& place) const {
    const Tile& tile = tile_with(place.tet);
    return tile.log_metric_at(place, place_in_tile(place.tet));
  }
  Tensor implied_log_at(const BackgroundPlace& place) const {
    const Tile& tile = tile_with(place.tet);
    return mean_of_corners(tile.implied, place, tile.to_vert[place_in_tile(place.tet)]);
  }

  /// The tile that has a tet, and the tet's place in it.
  struct TetOfTile {
    const Tile& tile;
    std::uint32_t place;
  };
  TetOfTile find(BackgroundTet tet) const { return {tile_with(tet), place_in_tile(tet)}; }

  /// The values of all fields on points there; see BackgroundMesh::value_at.
  void fields_at(const BackgroundPlace& place, std::span<double> values) const;

  std::size_t tile_count() const { return held_.size(); }
  /// That has a tet, at hand or not.
  std::uint32_t tile_of(BackgroundTet tet) const {
    return static_cast<std::uint32_t>((tet - index_.first_name) / kTileTets);
  }
  BackgroundTet name_of(std::uint32_t tile, std::uint32_t place) const {
    return index_.first_name + BackgroundTet{tile} * kTileTets + place;
  }
  /// Sets `marks` to 1, one of each tile, for the tiles that have something in the box.
  void mark_tiles(const Box3& box, std::span<std::uint8_t> marks) const {
    for_each_near(tets_.tree(), box, [&](std::uint32_t item) {
      const TileBox& one = tets_.all[item];
      if (marks[one.tile] == 0 && one.box.overlaps(box)) marks[one.tile] = 1;
    });
  }

  /// These tiles are at hand afterwards, and no others but those at home. In SharedWork::together.
  void fetch_only(std::vector<std::uint32_t>&& tiles, const SharedWork& work);
  /// Calls `look_up` with some of the uses after the other, which are those of a few tiles that are at hand then; with
  /// none where other ranks have more of them. `uses` ascend. In SharedWork::together, as is `look_up`.
  void for_some_tiles(std::span<const TileUse> uses, const SharedWork& work,
                      const std::function<void(std::span<const TileUse>)>& look_up);
  /// Gives back what came from elsewhere.
  void drop_fetched();
  /// Gives back the implied metrics, here and, as all ranks call it, elsewhere.
  void drop_implied();

  /// Calls `look_up`, and says whether it found all tiles. Any thread, several at once.
  bool finds(const std::function<void()>& look_up) const;
  /// Calls `attempt` on all ranks, each with SharedWork::each, and again with what was missing fetched, as long as on
  /// any rank something was missing, as `finds` said or Pausable work waits for. In SharedWork::together.
  void until_found(const SharedWork& work, const std::function<void()>& attempt);

 private:
  struct Held {
    explicit Held(Bytes&& all) : bytes(std::move(all)), tile(Tile::read(bytes)) {}
    Bytes bytes;
    Tile tile;
  };

  std::uint32_t place_in_tile(BackgroundTet tet) const {
    return static_cast<std::uint32_t>((tet - index_.first_name) % kTileTets);
  }
  const Tile& tile_with(BackgroundTet tet) const {
    const std::uint32_t tile = tile_of(tet);
    while (held_[tile] == nullptr) [[unlikely]] wait_for(tile);
    return held_[tile]->tile;
  }
  void wait_for(std::uint32_t tile) const;
  bool is_own(std::uint32_t tile) const { return tile >= first_own_ && tile < last_own_; }
  void look_in_box(const TileBox& box, const Vec3& x, NearestOnBoundary& nearest, std::uint64_t& number) const;
  std::vector<std::uint32_t> with_ring(std::span<const std::uint32_t> tiles) const;
  void fetch(std::vector<std::uint32_t>&& tiles, const SharedWork& work);
  void fetch_some(std::span<const std::uint32_t> tiles, const SharedWork& work);
  bool fetch_missing(const SharedWork& work);

  /// Boxes of all tiles, with a tree over them.
  struct Boxes {
    Boxes(std::vector<TileBox>&& given, const TaskRunner& runner);
    BvhView tree() const { return {nodes.span(), order.span()}; }
    void move_arrays(const KeepBytes& keep);

    FixedArray<TileBox> all;
    FixedArray<BvhNode> nodes;
    FixedArray<std::uint32_t> order;
  };

  Index index_;  // without its boxes
  std::uint32_t first_own_, last_own_;
  Boxes tets_, faces_;
  std::vector<std::unique_ptr<Held>> held_;  // by tile
  mutable std::mutex mutex_;                 // around what follows
  mutable std::vector<std::uint32_t> missing_;
};

/// Those whose mark is not 0, ascending.
std::vector<std::uint32_t> marked(std::span<const std::uint8_t> marks);

/// As BackgroundTiles::finds; true where there are no tiles.
inline bool finds(const BackgroundTiles* tiles, const std::function<void()>& look_up) {
  if (tiles != nullptr) return tiles->finds(look_up);
  look_up();
  return true;
}
/// As BackgroundTiles::until_found; a single attempt where there are no tiles.
inline void until_found(BackgroundTiles* tiles, const SharedWork& work, const std::function<void()>& attempt) {
  if (tiles != nullptr) return tiles->until_found(work, attempt);
  work.each(attempt);
}

/// For blocks of at most `grain` numbers below `count` calls `begin()`, and what it returns with each number. Where
/// there are tiles: with those of a few tiles at a time, which are at hand then, by the tile `tile_of(i)` that number i
/// needs first; again with those that asked for another one, once that is at hand too. Some of the tiles are at hand
/// afterwards. In SharedWork::together where there are tiles.
template <class TileOf, class Begin>
void look_up_all(BackgroundTiles* tiles, std::size_t count, std::size_t grain, const SharedWork& work,
                 const TileOf& tile_of, const Begin& begin) {
  if (tiles == nullptr) {
    work.runner().for_blocks(count, grain, [&](std::size_t first, std::size_t last) {
      auto look_up = begin();
      for (std::size_t i = first; i < last; ++i) look_up(i);
    });
    return;
  }
  std::vector<TileUse> uses;
  work.each([&] {
    uses.reserve(count);
    for (std::uint32_t i = 0; i < count; ++i) uses.push_back({tile_of(i), i});
    std::ranges::sort(uses);
  });
  tiles->for_some_tiles(uses, work, [&](std::span<const TileUse> some) {
    std::vector<std::vector<std::uint32_t>> waiting((some.size() + grain - 1) / grain);
    for (std::size_t i = 0; i < some.size(); ++i) waiting[i / grain].push_back(some[i].number);
    tiles->until_found(work, [&] {
      work.runner().for_each(waiting.size(), [&](std::size_t block) {
        auto look_up = begin();
        std::erase_if(waiting[block], [&](std::uint32_t i) { return tiles->finds([&] { look_up(i); }); });
      });
    });
  });
}

}  // namespace tetloom::adapt
