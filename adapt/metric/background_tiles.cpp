#include "adapt/metric/background_tiles.hpp"

#include <algorithm>
#include <array>
#include <utility>

#include "adapt/metric/tet_links.hpp"
#include "core/base/free_memory.hpp"
#include "core/base/lists.hpp"
#include "core/spatial/distances.hpp"
#include "threading/runtime/pausable.hpp"

namespace tetloom::adapt {

std::vector<std::uint32_t> marked(std::span<const std::uint8_t> marks) {
  std::vector<std::uint32_t> all;
  for (std::uint32_t i = 0; i < marks.size(); ++i)
    if (marks[i] != 0) all.push_back(i);
  return all;
}

BackgroundTiles::BackgroundTiles(std::vector<Bytes>&& own, Index&& index, int rank, const TaskRunner& runner)
    : index_(std::move(index)),
      first_own_(index_.first_tiles[static_cast<std::size_t>(rank)]),
      last_own_(index_.first_tiles[static_cast<std::size_t>(rank) + 1]),
      tets_(std::exchange(index_.tets, {}), runner),
      faces_(std::exchange(index_.faces, {}), runner),
      held_(index_.first_tiles.back()) {
  for (std::uint32_t i = 0; i < own.size(); ++i) held_[first_own_ + i] = std::make_unique<Held>(std::move(own[i]));
}

BackgroundTiles::Boxes::Boxes(std::vector<TileBox>&& given, const TaskRunner& runner) {
  std::vector<Box3> boxes;
  boxes.reserve(given.size());
  for (const TileBox& one : given) boxes.push_back(one.box);
  Bvh bvh = build_bvh(boxes, runner);
  all = FixedArray(std::move(given));
  nodes = FixedArray(std::move(bvh.nodes));
  order = FixedArray(std::move(bvh.order));
}

void BackgroundTiles::Boxes::move_arrays(const KeepBytes& keep) {
  all.move_to(keep);
  nodes.move_to(keep);
  order.move_to(keep);
}

void BackgroundTiles::move_boxes(const KeepBytes& keep) {
  tets_.move_arrays(keep);
  faces_.move_arrays(keep);
}

void BackgroundTiles::look_in_box(const TileBox& box, const Vec3& x, NearestOnBoundary& nearest,
                                  std::uint64_t& number) const {
  const Tile& tile = held_[box.tile]->tile;
  const std::size_t end = std::min<std::size_t>(tile.boundary.size(), box.first + kFacesOfBox);
  for (std::size_t i = box.first; i < end; ++i) {
    const std::uint32_t place = tile.boundary[i] / 4, face = tile.boundary[i] % 4;
    const std::array<Vec3, 4> c = tile.corners(place);
    const auto& f = kFaceVerts[face];
    const TrianglePoint point = closest_on_triangle(x, c[f[0]], c[f[1]], c[f[2]]);
    const std::uint64_t own = tile.numbers[place] * 4 + face;
    const bool nearer = point.distance2 < nearest.point.distance2;
    const bool equal = point.distance2 == nearest.point.distance2 && nearest.face.valid();
    if (!nearer && !(equal && own < number)) continue;
    nearest = {BackgroundFace(name_of(box.tile, place), face), point};
    number = own;
  }
}

// Boxes whose tile is not at hand may still turn out to be too far away.
NearestOnBoundary BackgroundTiles::nearest(const Vec3& x) const {
  NearestOnBoundary nearest;
  std::uint64_t number = 0;
  double reach2 = HUGE_VAL;
  std::vector<std::uint32_t> unknown;
  const auto distance_to = [&](const TileBox& box) { return squared_distance_to_box(x, box.box); };
  visit_nearest_first(
      faces_.tree(), x, [&] { return reach2; },
      [&](std::uint32_t position) {
        const std::uint32_t item = faces_.order[position];
        const TileBox& box = faces_.all[item];
        if (distance_to(box) > reach2) return;
        if (held_[box.tile] == nullptr) return unknown.push_back(item);
        look_in_box(box, x, nearest, number);
        reach2 = reach_of_boxes(nearest.point.distance2, x);
      });
  const TileBox* missing = nullptr;
  for (const std::uint32_t item : unknown) {
    const TileBox& box = faces_.all[item];
    if (distance_to(box) > reach2) continue;
    if (missing == nullptr || distance_to(box) < distance_to(*missing)) missing = &box;
  }
  if (missing == nullptr) return nearest;
  wait_for(missing->tile);
  return this->nearest(x);
}

// Is at hand afterwards, unless this throws.
void BackgroundTiles::wait_for(std::uint32_t tile) const {
  if (!Pausable::is_here()) throw MissingTile{tile};
  {
    const std::scoped_lock lock(mutex_);
    missing_.push_back(tile);
  }
  Pausable::pause();
}

void BackgroundTiles::fields_at(const BackgroundPlace& place, std::span<double> values) const {
  const Tile& tile = tile_with(place.tet);
  const auto& verts = tile.to_vert[place_in_tile(place.tet)];
  for (std::size_t c = 0; c < values.size(); ++c) {
    double sum = 0;
    for (std::size_t i = 0; i < 4; ++i) sum += place.weights[i] * tile.fields[verts[i] * values.size() + c];
    values[c] = sum;
  }
}

std::vector<std::uint32_t> BackgroundTiles::with_ring(std::span<const std::uint32_t> tiles) const {
  std::vector<std::uint8_t> marks(tile_count(), 0);
  for (const std::uint32_t tile : tiles) {
    const std::span<const TileBox> boxes = tets_.all.span();
    auto at = std::ranges::lower_bound(boxes, tile, {}, &TileBox::tile);
    for (; at != boxes.end() && at->tile == tile; ++at) mark_tiles(at->box, marks);
  }
  return marked(marks);
}

void BackgroundTiles::fetch_only(std::vector<std::uint32_t>&& tiles, const SharedWork& work) {
  std::vector<std::uint32_t> lacking;
  work.each([&] {
    sort_unique(tiles);
    for (std::uint32_t tile = 0; tile < held_.size(); ++tile)
      if (held_[tile] && !is_own(tile) && !std::ranges::binary_search(tiles, tile)) held_[tile].reset();
    for (const std::uint32_t tile : tiles)
      if (!held_[tile]) lacking.push_back(tile);
    tiles = {};
  });
  fetch(std::move(lacking), work);
}

// Some at a time, as messages are beside the tiles for a while: not much beside those at home. In an order that asks
// all ranks about equally at any time. `tiles`: of ranks that are not this one.
void BackgroundTiles::fetch(std::vector<std::uint32_t>&& tiles, const SharedWork& work) {
  constexpr std::size_t kLeastAtOnce = 64, kOfOwn = 32;
  const std::size_t at_once =
      std::max(kLeastAtOnce, tile_count() / static_cast<std::size_t>(work.rank_count()) / kOfOwn);
  std::ranges::sort(tiles, {}, [](std::uint32_t tile) { return tile * 2654435761u; });  // (Knuth 1998, 6.4)
  std::array<double, 1> most{static_cast<double>(tiles.size())};
  work.max(most);
  for (std::size_t first = 0; first < static_cast<std::size_t>(most[0]); first += at_once) {
    const std::size_t begin = std::min(first, tiles.size());
    fetch_some(std::span(tiles).subspan(begin, std::min(at_once, tiles.size() - begin)), work);
  }
}

void BackgroundTiles::fetch_some(std::span<const std::uint32_t> tiles, const SharedWork& work) {
  const auto home_of = [&](std::uint32_t tile) {
    return static_cast<std::size_t>(std::ranges::upper_bound(index_.first_tiles, tile) - index_.first_tiles.begin()) -
           1;
  };
  std::vector<std::vector<std::uint32_t>> wanted(static_cast<std::size_t>(work.rank_count()));
  for (const std::uint32_t tile : tiles) wanted[home_of(tile)].push_back(tile);
  const std::vector<Bytes> asked = work.exchange([&](std::span<MessageWriter> to) {
    for (std::size_t r = 0; r < to.size(); ++r) to[r].put_array(std::span<const std::uint32_t>(wanted[r]));
  });
  std::vector<Bytes> given = work.exchange([&](std::span<MessageWriter> to) {
    for (std::size_t r = 0; r < to.size(); ++r) {
      const auto numbers = MessageReader(asked[r]).get_view<std::uint32_t>();
      std::size_t size = 0;
      for (const std::uint32_t tile : numbers) size += held_[tile]->bytes.size() + sizeof(std::uint64_t);
      to[r].reserve(size);
      for (const std::uint32_t tile : numbers) to[r].put_array(std::span<const std::byte>(held_[tile]->bytes));
    }
  });
  work.each([&] {
    for (std::size_t r = 0; r < given.size(); ++r) {
      MessageReader reader(given[r]);
      for (const std::uint32_t tile : wanted[r])
        held_[tile] = std::make_unique<Held>(Bytes(reader.get_view<std::byte>()));
      given[r] = Bytes();
    }
  });
}

void BackgroundTiles::for_some_tiles(std::span<const TileUse> uses, const SharedWork& work,
                                     const std::function<void(std::span<const TileUse>)>& look_up) {
  constexpr std::size_t kAtOnce = 128;
  std::vector<std::uint32_t> tiles;
  std::vector<std::size_t> firsts;  // uses of each of them
  for (std::size_t i = 0; i < uses.size(); ++i)
    if (tiles.empty() || tiles.back() != uses[i].tile) tiles.push_back(uses[i].tile), firsts.push_back(i);
  firsts.push_back(uses.size());
  std::array<double, 1> most{static_cast<double>(tiles.size())};
  work.max(most);
  for (std::size_t first = 0; first < static_cast<std::size_t>(most[0]); first += kAtOnce) {
    const std::size_t begin = std::min(first, tiles.size()), end = std::min(first + kAtOnce, tiles.size());
    fetch_only({tiles.begin() + static_cast<std::ptrdiff_t>(begin), tiles.begin() + static_cast<std::ptrdiff_t>(end)},
               work);
    look_up(uses.subspan(firsts[begin], firsts[end] - firsts[begin]));
  }
}

void BackgroundTiles::drop_fetched() {
  for (std::uint32_t tile = 0; tile < held_.size(); ++tile)
    if (!is_own(tile)) held_[tile].reset();
  give_back_free_memory();
}

void BackgroundTiles::drop_implied() {
  drop_fetched();
  for (std::uint32_t tile = first_own_; tile < last_own_; ++tile) {
    Tile without = held_[tile]->tile;
    without.implied = {};
    held_[tile] = std::make_unique<Held>(bytes_of(without));
  }
}

bool BackgroundTiles::finds(const std::function<void()>& look_up) const {
  try {
    look_up();
    return true;
  } catch (const MissingTile& missing) {
    const std::scoped_lock lock(mutex_);
    missing_.push_back(missing.tile);
    return false;
  }
}

// What lies around what is missing is likely to be asked for next.
bool BackgroundTiles::fetch_missing(const SharedWork& work) {
  std::vector<std::uint32_t> lacking;
  work.each([&] {
    sort_unique(missing_);
    lacking = with_ring(std::exchange(missing_, {}));
    std::erase_if(lacking, [&](std::uint32_t tile) { return held_[tile] != nullptr; });
  });
  std::array<std::int64_t, 1> count{static_cast<std::int64_t>(lacking.size())};
  work.sum(count);
  if (count[0] == 0) return false;
  fetch(std::move(lacking), work);
  return true;
}

void BackgroundTiles::until_found(const SharedWork& work, const std::function<void()>& attempt) {
  do {
    work.each(attempt);
  } while (fetch_missing(work));
}

}  // namespace tetloom::adapt
