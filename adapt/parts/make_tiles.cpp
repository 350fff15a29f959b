#include "adapt/parts/make_tiles.hpp"

#include <algorithm>
#include <array>
#include <functional>
#include <iterator>
#include <new>
#include <queue>
#include <utility>

#include "adapt/parts/home_tiles.hpp"
#include "adapt/parts/rounds.hpp"
#include "core/base/grain.hpp"
#include "core/base/local_numbers.hpp"
#include "core/spatial/hilbert.hpp"
#include "threading/comm/copy_of_machine.hpp"
#include "threading/runtime/parallel_sort.hpp"

namespace tetloom::adapt {

namespace {

constexpr std::size_t kSamplesPerRank = 64;  // for each other rank

// A tet of the share and its place along the curve.
struct KeyedTet {
  std::uint64_t key = 0;
  std::uint32_t tet = 0;
  friend auto operator<=>(const KeyedTet&, const KeyedTet&) = default;
};

// What lies behind a face of another rank, and that face as the other rank codes it.
struct NamedLink {
  BackgroundFace behind;
  FaceCode face;
};

// Of the tiles that ranks have, some are made at a time.
constexpr std::size_t kMostChunks = 8, kTilesOfChunk = 16;

// Places in several ascending lists, by their values and then by list: calls visit(list) for one after the other.
template <class Visit>
void merge_lists(const std::vector<std::span<const std::uint64_t>>& lists, const Visit& visit) {
  struct Head {
    std::uint64_t key;
    std::uint32_t list, next;
    auto operator<=>(const Head&) const = default;
  };
  std::priority_queue<Head, std::vector<Head>, std::greater<>> heads;
  for (std::uint32_t i = 0; i < lists.size(); ++i)
    if (!lists[i].empty()) heads.push({lists[i][0], i, 1});
  while (!heads.empty()) {
    Head head = heads.top();
    heads.pop();
    visit(head.list);
    if (head.next == lists[head.list].size()) continue;
    head.key = lists[head.list][head.next++];
    heads.push(head);
  }
}

template <class T>
void put_lists(const std::vector<std::vector<T>>& lists, std::span<MessageWriter> to) {
  for (std::size_t r = 0; r < to.size(); ++r) to[r].put_array(std::span<const T>(lists[r]));
}

class TileMaker {
 public:
  TileMaker(WholeMesh& share, const ShareLinks& links, std::span<const FaceOutside> faces, const ShareVerts& verts,
            const ShareCells& cells, const SharedWork& work)
      : share_(share),
        links_(links),
        faces_(faces),
        verts_(verts),
        cells_(cells),
        work_(work),
        runner_(work.runner()) {}

  std::unique_ptr<BackgroundTiles> run() {
    sort_tets();
    deal_to_homes();
    name_tets();
    name_links();
    name_hints();
    for (std::size_t chunk = 0; chunk < chunk_count(); ++chunk) make_chunk(chunk);
    share_tiles();
    auto tiles = std::make_unique<BackgroundTiles>(std::move(own_), std::move(index_), work_.rank(), runner_);
    tiles->move_boxes(copy_of_machine(work_.ranks()));
    return tiles;
  }

 private:
  std::size_t ranks() const { return static_cast<std::size_t>(work_.rank_count()); }
  std::size_t rank() const { return static_cast<std::size_t>(work_.rank()); }
  /// Of the share, in the whole mesh.
  Number first_tet() const { return links_.first_tets[rank()]; }
  std::span<const std::uint32_t> tets_for(std::size_t r) const {
    return std::span(order_).subspan(first_for_[r], first_for_[r + 1] - first_for_[r]);
  }

  void sort_tets() {
    const Box3 box = box_of(share_, work_);
    const Vec3 extent = box.hi - box.lo;
    const double scale = ((1 << kHilbertBits) - 1) / std::max({extent.x, extent.y, extent.z, 1e-300});
    work_.each([&] {
      tets_.resize(share_.size());
      runner_.for_blocks(tets_.size(), kElementGrain, [&](std::size_t begin, std::size_t end) {
        for (std::size_t tet = begin; tet < end; ++tet) {
          Vec3 sum;
          for (std::size_t i = 0; i < 4; ++i) sum += share_.points[share_.to_vert[tet * 4 + i]];
          const Vec3 x = scale * (0.25 * sum - box.lo);
          const std::uint64_t key = hilbert_key(static_cast<std::int64_t>(x.x), static_cast<std::int64_t>(x.y),
                                                static_cast<std::int64_t>(x.z));
          tets_[tet] = {key, static_cast<std::uint32_t>(tet)};
        }
      });
      parallel_sort(tets_, runner_);
    });
  }

  // Where the curve is cut follows from samples, so ranks have about equal numbers.
  void deal_to_homes() {
    const std::vector<Bytes> given = work_.all_gather([&](MessageWriter& writer) {
      const std::size_t count = std::min(tets_.size(), kSamplesPerRank * ranks());
      const auto room = writer.put_room<std::uint64_t>(count);
      for (std::size_t i = 0; i < count; ++i) room[i] = tets_[i * tets_.size() / count].key;
    });
    std::vector<std::uint64_t> keys = joined_lists<std::uint64_t>(given);
    std::ranges::sort(keys);
    first_for_.assign(1, 0);
    for (std::size_t r = 1; r < ranks(); ++r) {
      const std::uint64_t cut = keys[r * keys.size() / ranks()];
      first_for_.push_back(
          static_cast<std::size_t>(std::ranges::lower_bound(tets_, cut, {}, &KeyedTet::key) - tets_.begin()));
    }
    first_for_.push_back(tets_.size());
  }

  // Every rank tells where it has tets, and hears what they are called. Of tets in one place those of lower ranks,
  // which have lower numbers, come first.
  void name_tets() {
    const std::vector<Bytes> given = work_.exchange([&](std::span<MessageWriter> to) {
      for (std::size_t r = 0; r < to.size(); ++r)
        to[r].put_each(std::span(tets_).subspan(first_for_[r], first_for_[r + 1] - first_for_[r]),
                       [](const KeyedTet& one) { return one.key; });
      order_.resize(tets_.size());
      std::ranges::transform(tets_, order_.begin(), &KeyedTet::tet);
      tets_ = {};
    });
    std::vector<std::span<const std::uint64_t>> keys;
    for (const Bytes& bytes : given) keys.push_back(MessageReader(bytes).get_view<std::uint64_t>());
    for (const auto& of_rank : keys) own_count_ += of_rank.size();
    count_tiles();
    const std::vector<Bytes> told = work_.exchange([&](std::span<MessageWriter> to) {
      std::vector<std::span<BackgroundTet>> names;
      for (std::size_t r = 0; r < to.size(); ++r) names.push_back(to[r].put_room<BackgroundTet>(keys[r].size()));
      std::vector<std::size_t> next(to.size(), 0);
      BackgroundTet name = first_name_;
      merge_lists(keys, [&](std::uint32_t r) { names[r][next[r]++] = name++; });
    });
    to_name_.resize(share_.size());
    for (std::size_t r = 0; r < ranks(); ++r) {
      const auto of_rank = MessageReader(told[r]).get_view<BackgroundTet>();
      for (std::size_t i = 0; i < of_rank.size(); ++i) to_name_[tets_for(r)[i]] = of_rank[i];
    }
  }

  void count_tiles() {
    const auto tiles = static_cast<std::uint64_t>((own_count_ + kTileTets - 1) / kTileTets);
    std::uint64_t sum = 0;
    index_.first_tiles.assign(1, 0);
    for (const Bytes& bytes : work_.all_gather([&](MessageWriter& writer) { writer.put(tiles); })) {
      sum += MessageReader(bytes).get<std::uint64_t>();
      if (sum >= kNone) throw std::bad_alloc();  // 2^41 tets
      index_.first_tiles.push_back(static_cast<std::uint32_t>(sum));
    }
    index_.tet_count = links_.tet_count();
    index_.first_name = first_number() / kTileTets * kTileTets;
    first_name_ = name_of(index_.first_tiles[rank()]);
  }

  // Behind faces between ranks lies what the other rank tells.
  void name_links() {
    const std::vector<Bytes> told = work_.exchange([&](std::span<MessageWriter> to) {
      std::vector<std::vector<NamedLink>> faces(to.size());
      for (const FaceOutside& one : faces_)
        faces[one.behind.rank].push_back({{to_name_[one.face.tet()], one.face.side()}, one.behind.face});
      put_lists(faces, to);
    });
    behind_.resize(faces_.size());
    for (const Bytes& bytes : told)
      for (const auto& [behind, face] : MessageReader(bytes).get_view<NamedLink>()) behind_[place_of(face)] = behind;
  }

  // Among the faces between ranks.
  std::size_t place_of(FaceCode face) const {
    return static_cast<std::size_t>(std::ranges::lower_bound(faces_, face, {}, &FaceOutside::face) - faces_.begin());
  }

  // By names.
  BackgroundFace link_of(FaceCode face) const {
    const FaceCode behind = share_.behind(face);
    if (behind.valid()) return {to_name_[behind.tet()], behind.side()};
    const std::size_t place = place_of(face);
    return place < faces_.size() && faces_[place].face == face ? behind_[place] : BackgroundFace();
  }

  void name_hints() {
    std::vector<std::vector<std::uint32_t>> wanted(ranks()), verts(ranks());  // tets of other ranks, as those name them
    for (std::uint32_t v = 0; v < verts_.to_start.size(); ++v) {
      const std::size_t r = rank_in(links_.first_tets, verts_.to_start[v]);
      wanted[r].push_back(static_cast<std::uint32_t>(verts_.to_start[v] - links_.first_tets[r]));
      verts[r].push_back(v);
    }
    const std::vector<Bytes> asked = work_.exchange([&](std::span<MessageWriter> to) { put_lists(wanted, to); });
    const std::vector<Bytes> told = work_.exchange([&](std::span<MessageWriter> to) {
      for (std::size_t r = 0; r < to.size(); ++r) {
        const auto tets = MessageReader(asked[r]).get_view<std::uint32_t>();
        to[r].put_each(tets, [&](std::uint32_t tet) { return to_name_[tet]; });
      }
    });
    for (std::size_t r = 0; r < ranks(); ++r) {
      const auto names = MessageReader(told[r]).get_view<BackgroundTet>();
      for (std::size_t i = 0; i < names.size(); ++i) share_.to_hint[verts[r][i]] = names[i];
    }
  }

  std::size_t tiles_of(std::size_t r) const { return index_.first_tiles[r + 1] - index_.first_tiles[r]; }
  std::size_t chunk_count() const {
    std::size_t most = 0;
    for (std::size_t r = 0; r < ranks(); ++r) most = std::max(most, tiles_of(r));
    return std::clamp<std::size_t>(most / kTilesOfChunk, 1, kMostChunks);
  }
  // Of the first tet in a tile.
  BackgroundTet name_of(std::size_t tile) const { return index_.first_name + tile * kTileTets; }
  NameRange range_of(std::size_t r, std::size_t chunk) const {
    const auto first_of = [&](std::size_t c) {
      return name_of(index_.first_tiles[r] + tiles_of(r) * c / chunk_count());
    };
    return {index_.first_name, first_of(chunk), first_of(chunk + 1)};
  }

  void make_chunk(std::size_t chunk) {
    std::vector<Bytes> given = work_.exchange([&](std::span<MessageWriter> to) {
      LocalNumbers verts(share_.points.size());
      for (std::size_t r = 0; r < to.size(); ++r) put_tets(tets_in(r, range_of(r, chunk)), verts, to[r]);
    });
    work_.each([&] {
      NameRange range = range_of(rank(), chunk);
      range.end = std::min(range.end, first_name_ + own_count_);
      const TileContents contents{verts_.has_metric, verts_.components, cells_.components, cells_.has_slopes};
      std::vector<Bytes> made = make_home_tiles(std::move(given), range, contents, runner_);
      std::ranges::move(made, std::back_inserter(own_));
    });
  }

  // Of those for a rank, which ascend in their names.
  std::span<const std::uint32_t> tets_in(std::size_t r, const NameRange& range) const {
    const auto tets = tets_for(r);
    const auto place = [&](BackgroundTet name) {
      return std::ranges::lower_bound(tets, name, {}, [&](std::uint32_t tet) { return to_name_[tet]; });
    };
    return {place(range.begin), place(range.end)};
  }

  // As make_home_tiles reads it. `verts`: working memory.
  void put_tets(std::span<const std::uint32_t> own, LocalNumbers& verts, MessageWriter& writer) const {
    verts.clear();
    for (const std::uint32_t tet : own)
      for (std::size_t i = 0; i < 4; ++i) verts.add(share_.to_vert[std::size_t{tet} * 4 + i]);
    constexpr std::size_t kLengths = 512;
    constexpr std::size_t kBytesOfTet = sizeof(FourVerts) + sizeof(FourFaces) + sizeof(BackgroundTet) + sizeof(Number);
    const std::size_t bytes_of_vert =
        sizeof(Number) + sizeof(Vec3) + 2 * sizeof(Tensor) + verts_.components * sizeof(double);
    const std::size_t n = cells_.components, slopes = cells_.has_slopes ? n : 0;
    const std::size_t bytes_of_cell = (n > 0 ? sizeof(std::uint32_t) : 0) + n * sizeof(double) + slopes * sizeof(Vec3);
    writer.reserve(kLengths + own.size() * (kBytesOfTet + bytes_of_cell) + verts.size() * bytes_of_vert);
    const auto slot = [&](FaceCode face) { return verts[share_.apex(face)]; };
    const auto link = [&](FaceCode face) { return link_of(face); };
    writer.put_each(own, [&](std::uint32_t tet) { return to_name_[tet]; });
    writer.put_each(own, [&](std::uint32_t tet) { return first_tet() - links_.first_tets.front() + tet; });
    writer.put_each(own, [&](std::uint32_t tet) { return tets::of_faces(tet, slot); });
    writer.put_each(own, [&](std::uint32_t tet) { return tets::of_faces(tet, link); });
    writer.put_each(n > 0 ? own : own.first(0), [&](std::uint32_t tet) { return share_.to_region[tet]; });
    put_several(own, cells_.values, n, writer), put_several(own, cells_.slopes, slopes, writer);
    const auto items = verts.items();
    writer.put_each(items, [&](std::uint32_t v) { return verts_.to_given[v]; });
    writer.put_each(items, [&](std::uint32_t v) { return share_.points[v]; });
    writer.put_each(items, [&](std::uint32_t v) { return verts_.has_metric ? verts_.logs[v] : Tensor(); });
    writer.put_each(items, [&](std::uint32_t v) { return verts_.implied[v]; });
    put_several(items, verts_.fields, verts_.components, writer);
  }

  // Of each of the tets or vertices `each` values.
  template <class T>
  static void put_several(std::span<const std::uint32_t> items, const std::vector<T>& values, std::size_t each,
                          MessageWriter& writer) {
    T* room = writer.put_room<T>(items.size() * each).data();
    for (const std::uint32_t i : items) room = std::copy_n(values.data() + i * each, each, room);
  }

  void share_tiles() {
    order_ = {}, to_name_ = {}, behind_ = {};
    std::vector<TileBox> tets, faces;
    for (std::size_t tile = 0; tile < own_.size(); ++tile)
      add_boxes(Tile::read(own_[tile]), index_.first_tiles[rank()] + static_cast<std::uint32_t>(tile), tets, faces);
    index_.tets = gather_lists<TileBox>(work_.ranks(), tets),
    index_.faces = gather_lists<TileBox>(work_.ranks(), faces);
  }

  WholeMesh& share_;
  const ShareLinks& links_;
  std::span<const FaceOutside> faces_;
  const ShareVerts& verts_;
  const ShareCells& cells_;
  const SharedWork& work_;
  const TaskRunner& runner_;
  std::vector<KeyedTet> tets_;          // of the share, along the curve
  std::vector<std::uint32_t> order_;    // the same without keys
  std::vector<std::size_t> first_for_;  // in both: where those for each rank begin, and how many there are
  std::vector<BackgroundTet> to_name_;  // of the share's tets
  std::vector<BackgroundFace> behind_;  // links of the faces between ranks, by names
  std::size_t own_count_ = 0;
  BackgroundTet first_name_ = 0;  // of the tiles at home here
  std::vector<Bytes> own_;
  BackgroundTiles::Index index_;
};

}  // namespace

std::unique_ptr<BackgroundTiles> make_tiles(WholeMesh& share, const ShareLinks& links,
                                            std::span<const FaceOutside> faces, const ShareVerts& verts,
                                            const ShareCells& cells, const SharedWork& work) {
  return TileMaker(share, links, faces, verts, cells, work).run();
}

}  // namespace tetloom::adapt
