#include "adapt/parts/make_tiles.hpp"

#include <algorithm>
#include <array>
#include <new>
#include <utility>

#include "adapt/parts/rounds.hpp"
#include "core/spatial/hilbert.hpp"
#include "threading/runtime/parallel_sort.hpp"

namespace tetloom::adapt {

namespace {

constexpr std::size_t kGrain = std::size_t{1} << 12;
constexpr std::size_t kSamplesPerRank = 64;  // for each other rank

using FourVerts = std::array<std::uint32_t, 4>;

// A tet and its place along the curve.
struct KeyedTet {
  std::uint64_t key = 0;
  std::uint32_t number = 0;
  std::uint32_t tet = 0;  // of the share; at home: of all that came
  friend auto operator<=>(const KeyedTet&, const KeyedTet&) = default;
};

std::size_t rank_in(const std::vector<std::uint32_t>& firsts, std::uint32_t number) {
  return static_cast<std::size_t>(std::ranges::upper_bound(firsts, number) - firsts.begin()) - 1;
}

template <class T>
void put_lists(const std::vector<std::vector<T>>& lists, std::span<MessageWriter> to) {
  for (std::size_t r = 0; r < to.size(); ++r) to[r].put_array(std::span<const T>(lists[r]));
}

// Vertices that came from all ranks, each once.
struct HomeVerts {
  std::vector<Vec3> points;
  std::vector<Tensor> logs, implied;
  std::vector<double> fields;
  std::vector<std::vector<std::uint32_t>> from_slots;  // of each rank's message
};

// Tets at home, by their names from the first one on.
struct HomeTets {
  std::vector<FourVerts> to_vert, links;
  std::vector<std::uint32_t> numbers;
};

class TileMaker {
 public:
  TileMaker(WholeMesh& share, const ShareLinks& links, const ShareVerts& verts, const SharedWork& work)
      : share_(share), links_(links), verts_(verts), work_(work), runner_(work.runner()) {}

  std::unique_ptr<BackgroundTiles> run() {
    sort_tets();
    deal_to_homes();
    name_tets();
    name_links();
    name_hints();
    send_tets();
    make_own();
    return std::make_unique<BackgroundTiles>(std::move(own_), std::move(index_), work_.rank(), runner_);
  }

 private:
  std::size_t ranks() const { return static_cast<std::size_t>(work_.rank_count()); }
  std::size_t rank() const { return static_cast<std::size_t>(work_.rank()); }
  std::uint32_t first_number() const { return links_.first_tets[rank()]; }
  std::span<const KeyedTet> tets_for(std::size_t r) const {
    return std::span(tets_).subspan(first_for_[r], first_for_[r + 1] - first_for_[r]);
  }

  void sort_tets() {
    const Box3 box = box_of(share_, work_);
    const Vec3 extent = box.hi - box.lo;
    const double scale = ((1 << kHilbertBits) - 1) / std::max({extent.x, extent.y, extent.z, 1e-300});
    work_.each([&] {
      tets_.resize(share_.size());
      runner_.for_blocks(tets_.size(), kGrain, [&](std::size_t begin, std::size_t end) {
        for (std::size_t tet = begin; tet < end; ++tet) {
          Vec3 sum;
          for (std::size_t i = 0; i < 4; ++i) sum += share_.points[share_.to_vert[tet * 4 + i]];
          const Vec3 x = scale * (0.25 * sum - box.lo);
          const std::uint64_t key = hilbert_key(static_cast<std::int64_t>(x.x), static_cast<std::int64_t>(x.y),
                                                static_cast<std::int64_t>(x.z));
          const auto own = static_cast<std::uint32_t>(tet);
          tets_[tet] = {key, first_number() + own, own};
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
    std::vector<std::uint64_t> keys;
    for (const Bytes& bytes : given) {
      const auto samples = MessageReader(bytes).get_view<std::uint64_t>();
      keys.insert(keys.end(), samples.begin(), samples.end());
    }
    std::ranges::sort(keys);
    first_for_.assign(1, 0);
    for (std::size_t r = 1; r < ranks(); ++r) {
      const std::uint64_t cut = keys[r * keys.size() / ranks()];
      first_for_.push_back(
          static_cast<std::size_t>(std::ranges::lower_bound(tets_, cut, {}, &KeyedTet::key) - tets_.begin()));
    }
    first_for_.push_back(tets_.size());
  }

  // Every rank tells what it has, and hears what it is called.
  void name_tets() {
    const std::vector<Bytes> given = work_.exchange([&](std::span<MessageWriter> to) {
      for (std::size_t r = 0; r < to.size(); ++r) to[r].put_array(tets_for(r));
    });
    std::vector<KeyedTet> all;
    std::vector<std::size_t> first_from(1, 0);
    work_.each([&] {
      for (const Bytes& bytes : given) {
        const auto tets = MessageReader(bytes).get_view<KeyedTet>();
        all.insert(all.end(), tets.begin(), tets.end());
        first_from.push_back(all.size());
      }
      for (std::uint32_t i = 0; i < all.size(); ++i) all[i].tet = i;
      parallel_sort(all, runner_);
    });
    own_count_ = all.size();
    count_tiles();
    std::vector<std::uint32_t> names(all.size());
    for (std::uint32_t i = 0; i < all.size(); ++i) names[all[i].tet] = first_name_ + i;
    all = {};
    const std::vector<Bytes> told = work_.exchange([&](std::span<MessageWriter> to) {
      for (std::size_t r = 0; r < to.size(); ++r)
        to[r].put_array(
            std::span<const std::uint32_t>(names).subspan(first_from[r], first_from[r + 1] - first_from[r]));
    });
    to_name_.resize(share_.size());
    for (std::size_t r = 0; r < ranks(); ++r) {
      const auto of_rank = MessageReader(told[r]).get_view<std::uint32_t>();
      for (std::size_t i = 0; i < of_rank.size(); ++i) to_name_[tets_for(r)[i].tet] = of_rank[i];
    }
  }

  void count_tiles() {
    const auto tiles = static_cast<std::uint64_t>((own_count_ + kTileTets - 1) / kTileTets);
    std::uint64_t sum = 0;
    index_.first_tiles.assign(1, 0);
    for (const Bytes& bytes : work_.all_gather([&](MessageWriter& writer) { writer.put(tiles); })) {
      sum += MessageReader(bytes).get<std::uint64_t>();
      if (sum * kTileTets >= CellPlace::kMaxTets * 2) throw std::bad_alloc();
      index_.first_tiles.push_back(static_cast<std::uint32_t>(sum));
    }
    index_.tet_count = links_.first_tets.back();
    first_name_ = index_.first_tiles[rank()] * kTileTets;
  }

  // Behind faces between ranks lies what the other rank tells.
  void name_links() {
    const std::vector<Bytes> told = work_.exchange([&](std::span<MessageWriter> to) {
      std::vector<std::vector<std::array<FaceCode, 2>>> faces(to.size());  // theirs, and what lies behind it
      for (const FaceOutside& one : links_.faces)
        faces[rank_in(links_.first_tets, one.behind / 4)].push_back(
            {one.behind, to_name_[one.face / 4] * 4 + one.face % 4});
      put_lists(faces, to);
    });
    work_.each([&] {
      to_link_.assign(share_.to_neighbor.begin(), share_.to_neighbor.end());
      for (std::uint32_t& link : to_link_)
        if (link != kNone) link = to_name_[link / 4] * 4 + link % 4;
      for (const Bytes& bytes : told)
        for (const auto& [face, behind] : MessageReader(bytes).get_view<std::array<FaceCode, 2>>())
          to_link_[face - first_number() * 4] = behind;
    });
  }

  void name_hints() {
    std::vector<std::vector<std::uint32_t>> wanted(ranks()), verts(ranks());
    for (std::uint32_t v = 0; v < verts_.to_start.size(); ++v) {
      const std::size_t r = rank_in(links_.first_tets, verts_.to_start[v]);
      wanted[r].push_back(verts_.to_start[v]), verts[r].push_back(v);
    }
    const std::vector<Bytes> asked = work_.exchange([&](std::span<MessageWriter> to) { put_lists(wanted, to); });
    const std::vector<Bytes> told = work_.exchange([&](std::span<MessageWriter> to) {
      for (std::size_t r = 0; r < to.size(); ++r) {
        const auto numbers = MessageReader(asked[r]).get_view<std::uint32_t>();
        std::ranges::transform(numbers, to[r].put_room<std::uint32_t>(numbers.size()).begin(),
                               [&](std::uint32_t number) { return to_name_[number - first_number()]; });
      }
    });
    for (std::size_t r = 0; r < ranks(); ++r) {
      const auto names = MessageReader(told[r]).get_view<std::uint32_t>();
      for (std::size_t i = 0; i < names.size(); ++i) share_.to_hint[verts[r][i]] = names[i];
    }
  }

  void send_tets() {
    std::vector<Bytes> given = work_.exchange([&](std::span<MessageWriter> to) {
      std::vector<std::uint32_t> to_slot(share_.points.size(), kNone);
      for (std::size_t r = 0; r < to.size(); ++r) put_tets(tets_for(r), to_slot, to[r]);
    });
    tets_ = {}, to_link_ = {}, to_name_ = {};
    work_.each([&] {
      home_verts_ = join_verts(given);
      take_tets(given);
    });
  }

  // `to_slot`: kNone all over, before and after.
  void put_tets(std::span<const KeyedTet> tets, std::vector<std::uint32_t>& to_slot, MessageWriter& writer) const {
    const auto put = [&](auto of, std::span<const std::uint32_t> items) {
      std::ranges::transform(items, writer.put_room<std::decay_t<decltype(of(0))>>(items.size()).begin(), of);
    };
    std::vector<std::uint32_t> own(tets.size()), verts;
    std::ranges::transform(tets, own.begin(), &KeyedTet::tet);
    for (const std::uint32_t tet : own) {
      for (std::size_t i = 0; i < 4; ++i) {
        std::uint32_t& slot = to_slot[share_.to_vert[std::size_t{tet} * 4 + i]];
        if (slot != kNone) continue;
        slot = static_cast<std::uint32_t>(verts.size());
        verts.push_back(share_.to_vert[std::size_t{tet} * 4 + i]);
      }
    }
    constexpr std::size_t kLengths = 128, kBytesOfTet = 2 * sizeof(FourVerts) + 2 * sizeof(std::uint32_t);
    const std::size_t bytes_of_vert =
        sizeof(std::uint32_t) + sizeof(Vec3) + 2 * sizeof(Tensor) + verts_.components * sizeof(double);
    writer.reserve(kLengths + own.size() * kBytesOfTet + verts.size() * bytes_of_vert);
    put([&](std::uint32_t tet) { return to_name_[tet]; }, own);
    put([&](std::uint32_t tet) { return first_number() + tet; }, own);
    const auto four = [](std::uint32_t tet, const auto& of) -> FourVerts {
      return {of(tet * 4), of(tet * 4 + 1), of(tet * 4 + 2), of(tet * 4 + 3)};
    };
    put([&](std::uint32_t tet) { return four(tet, [&](FaceCode c) { return to_slot[share_.to_vert[c]]; }); }, own);
    put([&](std::uint32_t tet) { return four(tet, [&](FaceCode f) { return to_link_[f]; }); }, own);
    put([&](std::uint32_t v) { return verts_.to_given[v]; }, verts);
    put([&](std::uint32_t v) { return share_.points[v]; }, verts);
    put([&](std::uint32_t v) { return verts_.has_metric ? verts_.logs[v] : Tensor(); }, verts);
    put([&](std::uint32_t v) { return verts_.implied[v]; }, verts);
    const auto fields = writer.put_room<double>(verts.size() * verts_.components);
    for (std::size_t i = 0; i < verts.size(); ++i)
      std::copy_n(verts_.fields.begin() + static_cast<std::ptrdiff_t>(verts[i] * verts_.components), verts_.components,
                  fields.begin() + static_cast<std::ptrdiff_t>(i * verts_.components));
    for (const std::uint32_t v : verts) to_slot[v] = kNone;
  }

  // What came from one rank, where it lies.
  struct Packet {
    explicit Packet(const Bytes& bytes) {
      MessageReader reader(bytes);
      names = reader.get_view<std::uint32_t>(), numbers = reader.get_view<std::uint32_t>();
      to_vert = reader.get_view<FourVerts>(), links = reader.get_view<FourVerts>();
      to_given = reader.get_view<std::uint32_t>(), points = reader.get_view<Vec3>();
      logs = reader.get_view<Tensor>(), implied = reader.get_view<Tensor>();
      fields = reader.get_view<double>();
    }
    std::span<const std::uint32_t> names, numbers, to_given;
    std::span<const FourVerts> to_vert, links;
    std::span<const Vec3> points;
    std::span<const Tensor> logs, implied;
    std::span<const double> fields;
  };

  HomeVerts join_verts(const std::vector<Bytes>& given) const {
    struct Came {
      std::uint32_t number, rank, slot;
      auto operator<=>(const Came&) const = default;
    };
    std::vector<Came> came;
    std::vector<Packet> packets(given.begin(), given.end());
    HomeVerts verts;
    for (std::uint32_t r = 0; r < packets.size(); ++r) {
      verts.from_slots.emplace_back(packets[r].to_given.size());
      for (std::uint32_t i = 0; i < packets[r].to_given.size(); ++i) came.push_back({packets[r].to_given[i], r, i});
    }
    std::ranges::sort(came);
    for (std::size_t i = 0; i < came.size(); ++i) {
      const Came& one = came[i];
      if (i == 0 || one.number != came[i - 1].number) {
        verts.points.push_back(packets[one.rank].points[one.slot]);
        verts.logs.push_back(packets[one.rank].logs[one.slot]);
        verts.implied.push_back(packets[one.rank].implied[one.slot]);
        for (std::size_t c = 0; c < verts_.components; ++c)
          verts.fields.push_back(packets[one.rank].fields[one.slot * verts_.components + c]);
      }
      verts.from_slots[one.rank][one.slot] = static_cast<std::uint32_t>(verts.points.size() - 1);
    }
    return verts;
  }

  void take_tets(std::vector<Bytes>& given) {
    home_tets_.to_vert.resize(own_count_), home_tets_.links.resize(own_count_), home_tets_.numbers.resize(own_count_);
    for (std::size_t r = 0; r < given.size(); ++r) {
      const Packet packet(given[r]);
      for (std::size_t i = 0; i < packet.names.size(); ++i) {
        const std::size_t at = packet.names[i] - first_name_;
        for (std::size_t j = 0; j < 4; ++j) home_tets_.to_vert[at][j] = home_verts_.from_slots[r][packet.to_vert[i][j]];
        home_tets_.links[at] = packet.links[i], home_tets_.numbers[at] = packet.numbers[i];
      }
      given[r] = Bytes();
    }
  }

  void make_own() {
    std::vector<TileBox> tets, faces;
    work_.each([&] {
      own_.resize((own_count_ + kTileTets - 1) / kTileTets);
      runner_.for_each(own_.size(), [&](std::size_t tile) { own_[tile] = make_tile(tile * kTileTets); });
      home_tets_ = {}, home_verts_ = {};
      for (std::size_t tile = 0; tile < own_.size(); ++tile)
        add_boxes(Tile::read(own_[tile]), index_.first_tiles[rank()] + static_cast<std::uint32_t>(tile), tets, faces);
    });
    index_.tets = gather(tets), index_.faces = gather(faces);
  }

  std::vector<TileBox> gather(const std::vector<TileBox>& own) const {
    std::vector<TileBox> all;
    for (const Bytes& bytes :
         work_.all_gather([&](MessageWriter& writer) { writer.put_array(std::span<const TileBox>(own)); })) {
      const auto boxes = MessageReader(bytes).get_view<TileBox>();
      all.insert(all.end(), boxes.begin(), boxes.end());
    }
    return all;
  }

  Bytes make_tile(std::size_t begin) const {
    const std::size_t count = std::min<std::size_t>(kTileTets, own_count_ - begin);
    std::vector<std::uint32_t> verts;
    for (std::size_t i = begin; i < begin + count; ++i)
      verts.insert(verts.end(), home_tets_.to_vert[i].begin(), home_tets_.to_vert[i].end());
    std::ranges::sort(verts);
    verts.erase(std::unique(verts.begin(), verts.end()), verts.end());
    std::vector<Vec3> points;
    std::vector<Tensor> logs, implied;
    std::vector<double> fields;
    for (const std::uint32_t v : verts) {
      points.push_back(home_verts_.points[v]), implied.push_back(home_verts_.implied[v]);
      if (verts_.has_metric) logs.push_back(home_verts_.logs[v]);
      for (std::size_t c = 0; c < verts_.components; ++c)
        fields.push_back(home_verts_.fields[v * verts_.components + c]);
    }
    std::vector<std::array<std::uint16_t, 4>> to_vert(count);
    std::vector<std::uint16_t> boundary;
    for (std::size_t i = 0; i < count; ++i) {
      for (std::size_t j = 0; j < 4; ++j) {
        const auto at = std::ranges::lower_bound(verts, home_tets_.to_vert[begin + i][j]);
        to_vert[i][j] = static_cast<std::uint16_t>(at - verts.begin());
        if (home_tets_.links[begin + i][j] == kNone) boundary.push_back(static_cast<std::uint16_t>(i * 4 + j));
      }
    }
    return bytes_of({points, logs, implied, fields, to_vert, std::span(home_tets_.links).subspan(begin, count),
                     std::span(home_tets_.numbers).subspan(begin, count), boundary});
  }

  WholeMesh& share_;
  const ShareLinks& links_;
  const ShareVerts& verts_;
  const SharedWork& work_;
  const TaskRunner& runner_;
  std::vector<KeyedTet> tets_;          // of the share, along the curve
  std::vector<std::size_t> first_for_;  // in tets_: where those of each rank begin, and how many there are
  std::vector<std::uint32_t> to_name_;  // of the share's tets
  std::vector<std::uint32_t> to_link_;  // of the share's faces, by names
  HomeVerts home_verts_;
  HomeTets home_tets_;
  std::size_t own_count_ = 0;
  std::uint32_t first_name_ = 0;
  std::vector<Bytes> own_;
  BackgroundTiles::Index index_;
};

}  // namespace

std::unique_ptr<BackgroundTiles> make_tiles(WholeMesh& share, const ShareLinks& links, const ShareVerts& verts,
                                            const SharedWork& work) {
  return TileMaker(share, links, verts, work).run();
}

}  // namespace tetloom::adapt
