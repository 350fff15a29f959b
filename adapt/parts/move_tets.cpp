#include <algorithm>
#include <array>
#include <utility>

#include "adapt/parts/share.hpp"
#include "core/base/free_memory.hpp"
#include "core/base/lists.hpp"
#include "core/base/local_numbers.hpp"
#include "core/part/adjacency.hpp"
#include "tetloom/tasks.hpp"
#include "threading/runtime/parallel_sort.hpp"

namespace tetloom::adapt {

namespace {

constexpr std::size_t kGrain = std::size_t{1} << 14;
// In messages: a neighbour is named by its number in the whole mesh, and not by its place in the message.
constexpr std::uint32_t kByNumber = 1u << 29;

static_assert(CellPlace::kMaxTets <= kByNumber);

// What each rank gets of a share.
struct Dealt {
  std::span<const std::uint32_t> to_part;             // of all tets of the share
  std::vector<std::uint32_t> to_rank, to_place;       // of each the rank it goes to, and its place among those
  std::vector<std::vector<std::uint32_t>> tets;       // per rank
  std::vector<std::vector<std::uint32_t>> triangles;  // per rank: those at its tets
  std::uint32_t first = 0;                            // number of the first tet of the share
};

// One rank's tets for others, each in one message. Vertices are named by their places in the list of those of the
// message.
class Packer {
 public:
  Packer(const WholeMesh& share, const ShareLinks& links, const Dealt& all)
      : share_(share), links_(links), all_(all), verts_(share.points.size()) {}

  void run(std::uint32_t rank, MessageWriter& writer) {
    rank_ = rank, tets_ = all_.tets[rank];
    verts_.clear(), pieces_.clear(), triangles_.clear();
    for (const std::uint32_t tet : tets_)
      for (std::size_t i = 0; i < 4; ++i) verts_.add(share_.to_vert[std::size_t{tet} * 4 + i]);
    find_pieces();
    find_triangles();
    writer.reserve(bytes());
    writer.put_each(tets_, [&](std::uint32_t tet) { return all_.first + tet; });
    writer.put_each(tets_, [&](std::uint32_t tet) { return all_.to_part[tet]; });
    writer.put_each(tets_, [&](std::uint32_t tet) { return share_.to_region[tet]; });
    const auto slot = [&](FaceCode face) { return verts_[share_.apex(face)]; };
    const auto link = [&](FaceCode face) { return behind(face); };
    writer.put_each(tets_, [&](std::uint32_t tet) { return tets::of_faces(tet, slot); });
    writer.put_each(tets_, [&](std::uint32_t tet) { return tets::of_faces(tet, link); });
    put_verts(writer);
    writer.put_array(std::span<const ModelEdgePiece>(pieces_));
    writer.put_array(std::span<const LinkedTriangle>(triangles_));
  }

 private:
  static constexpr std::size_t kBytesOfTet = 11 * sizeof(std::uint32_t);
  static constexpr std::size_t kBytesOfVert =
      sizeof(Vec3) + sizeof(VertexMetric) + 3 * sizeof(std::uint32_t) + sizeof(std::uint8_t);

  // A little more than it takes.
  std::size_t bytes() const {
    constexpr std::size_t kLengths = 512;
    return kLengths + tets_.size() * kBytesOfTet + verts_.size() * kBytesOfVert +
           pieces_.size() * sizeof(ModelEdgePiece) + triangles_.size() * sizeof(LinkedTriangle);
  }

  FaceCode behind(FaceCode face) const {
    const FaceCode behind = share_.behind(face);
    if (!behind.valid()) {
      const FaceCode outside = links_.behind(face);
      return outside.valid() ? outside.of_tet(outside.tet() | kByNumber) : outside;
    }
    const std::uint32_t tet = behind.tet();
    return behind.of_tet(all_.to_rank[tet] == rank_ ? all_.to_place[tet] : (tet + all_.first) | kByNumber);
  }

  void put_verts(MessageWriter& writer) const {
    writer.put_each(verts_.items(), [&](std::uint32_t v) { return links_.number_of(v); });
    writer.put_each(verts_.items(), [&](std::uint32_t v) { return share_.points[v]; });
    writer.put_each(verts_.items(), [&](std::uint32_t v) { return share_.to_metric[v]; });
    writer.put_each(verts_.items(), [&](std::uint32_t v) { return share_.to_entity[v]; });
    writer.put_each(verts_.items(), [&](std::uint32_t v) { return share_.to_hint[v]; });
    writer.put_each(verts_.items(), [&](std::uint32_t v) { return share_.to_state[v]; });
  }

  void find_pieces() {
    for (const std::uint32_t tet : tets_)
      for_each_piece(share_, tet, [&](const ModelEdgePiece& piece) { pieces_.push_back(piece); });
    sort_pieces(pieces_);
    for (ModelEdgePiece& piece : pieces_)
      for (std::uint32_t& v : piece.verts) v = verts_[v];
  }

  // With those of their tets that are in the message.
  void find_triangles() {
    for (const std::uint32_t triangle : all_.triangles[rank_]) {
      LinkedTriangle t = share_.triangles[triangle];
      for (std::uint32_t& tet : t.tets) tet = tet != kNone && all_.to_rank[tet] == rank_ ? all_.to_place[tet] : kNone;
      if (t.tets[0] == kNone) std::swap(t.tets[0], t.tets[1]);
      for (std::uint32_t& v : t.triangle.verts) v = verts_[v];
      triangles_.push_back(t);
    }
  }

  const WholeMesh& share_;
  const ShareLinks& links_;
  const Dealt& all_;
  std::uint32_t rank_ = 0;
  std::span<const std::uint32_t> tets_;
  LocalNumbers verts_;
  std::vector<ModelEdgePiece> pieces_;
  std::vector<LinkedTriangle> triangles_;
};

// What came from one rank, where it lies.
struct Packet {
  explicit Packet(const Bytes& bytes) {
    MessageReader reader(bytes);
    numbers = reader.get_view<std::uint32_t>(), parts = reader.get_view<std::uint32_t>();
    regions = reader.get_view<std::uint32_t>();
    to_vert = reader.get_view<std::array<std::uint32_t, 4>>();
    to_neighbor = reader.get_view<std::array<FaceCode, 4>>();
    vert_numbers = reader.get_view<std::uint32_t>();
    points = reader.get_view<Vec3>(), to_metric = reader.get_view<VertexMetric>();
    to_entity = reader.get_view<PackedEntity>(), to_hint = reader.get_view<std::uint32_t>();
    to_state = reader.get_view<std::uint8_t>();
    edges = reader.get_view<ModelEdgePiece>(), triangles = reader.get_view<LinkedTriangle>();
  }

  std::span<const std::uint32_t> numbers, parts, regions, vert_numbers, to_hint;
  std::span<const std::array<std::uint32_t, 4>> to_vert;
  std::span<const std::array<FaceCode, 4>> to_neighbor;
  std::span<const Vec3> points;
  std::span<const VertexMetric> to_metric;
  std::span<const PackedEntity> to_entity;
  std::span<const std::uint8_t> to_state;
  std::span<const ModelEdgePiece> edges;
  std::span<const LinkedTriangle> triangles;
  std::uint32_t first_tet = 0;          // place of its tets among all
  std::vector<std::uint32_t> to_local;  // of its vertices
};

// The tets of all packets, which are ascending in number: so ranks have numbered them. Packets are freed on the way.
class Unpacker {
 public:
  Unpacker(std::vector<Bytes>&& given, const TaskRunner& runner) : runner_(runner), given_(std::move(given)) {
    std::size_t tets = 0;
    for (const Bytes& bytes : given_) {
      Packet& packet = packets_.emplace_back(bytes);
      packet.first_tet = static_cast<std::uint32_t>(tets);
      tets += packet.numbers.size();
    }
    numbers_.reserve(tets);
    for (const Packet& packet : packets_) numbers_.insert(numbers_.end(), packet.numbers.begin(), packet.numbers.end());
  }

  RoundShare run() {
    take_verts();
    take_edges();
    take_triangles();
    take_tets();
    return std::move(share_);
  }

 private:
  // Several packets may have a vertex, the same in all.
  void take_verts() {
    std::vector<std::array<std::uint32_t, 3>> all;  // number, packet, place in it
    for (std::uint32_t p = 0; p < packets_.size(); ++p) {
      packets_[p].to_local.resize(packets_[p].vert_numbers.size());
      for (std::uint32_t i = 0; i < packets_[p].vert_numbers.size(); ++i)
        all.push_back({packets_[p].vert_numbers[i], p, i});
    }
    parallel_sort(all, runner_);
    WholeMesh& mesh = share_.mesh;
    for (const auto& [number, p, i] : all) {
      Packet& packet = packets_[p];
      if (share_.to_number.empty() || share_.to_number.back() != number) {
        share_.to_number.push_back(number);
        mesh.points.push_back(packet.points[i]), mesh.to_metric.push_back(packet.to_metric[i]);
        mesh.to_entity.push_back(packet.to_entity[i]), mesh.to_hint.push_back(packet.to_hint[i]);
        mesh.to_state.push_back(packet.to_state[i]);
      }
      packet.to_local[i] = static_cast<std::uint32_t>(share_.to_number.size() - 1);
    }
  }

  void take_tets() {
    WholeMesh& mesh = share_.mesh;
    mesh.to_vert.resize_for_overwrite(numbers_.size() * 4), mesh.to_neighbor.resize_for_overwrite(numbers_.size() * 4);
    share_.to_part.reserve(numbers_.size()), mesh.to_region.reserve(numbers_.size());
    for (std::size_t p = 0; p < packets_.size(); ++p) {
      const Packet& packet = packets_[p];
      share_.to_part.append(packet.parts);
      mesh.to_region.append(packet.regions);
      runner_.for_blocks(packet.to_vert.size(), kGrain, [&](std::size_t begin, std::size_t end) {
        for (std::size_t tet = begin; tet < end; ++tet) {
          const std::size_t first = (packet.first_tet + tet) * 4;
          for (std::size_t i = 0; i < 4; ++i) {
            mesh.to_vert[first + i] = packet.to_local[packet.to_vert[tet][i]];
            mesh.to_neighbor[first + i] = neighbor_of(packet, packet.to_neighbor[tet][i]);
          }
        }
      });
      given_[p] = Bytes();
    }
  }

  FaceCode neighbor_of(const Packet& packet, FaceCode named) const {
    if (!named.valid()) return {};
    if ((named.tet() & kByNumber) == 0) return named.of_tet(named.tet() + packet.first_tet);
    const std::uint32_t number = named.tet() & ~kByNumber;
    const auto at = std::ranges::lower_bound(numbers_, number);
    if (at == numbers_.end() || *at != number) return {};
    return named.of_tet(static_cast<std::uint32_t>(at - numbers_.begin()));
  }

  void take_edges() {
    for (const Packet& packet : packets_) {
      for (ModelEdgePiece piece : packet.edges) {
        for (std::uint32_t& v : piece.verts) v = packet.to_local[v];
        std::ranges::sort(piece.verts);
        share_.mesh.edges.push_back(piece);
      }
    }
    sort_pieces(share_.mesh.edges);
  }

  // Of a triangle that came with one tet from each of two ranks, one copy stays, with both.
  void take_triangles() {
    struct Half {
      Triangle verts;
      std::uint32_t triangle;
      auto operator<=>(const Half&) const = default;
    };
    std::vector<LinkedTriangle>& triangles = share_.mesh.triangles;
    std::vector<Half> halves;
    for (const Packet& packet : packets_) {
      for (LinkedTriangle t : packet.triangles) {
        for (std::uint32_t& v : t.triangle.verts) v = packet.to_local[v];
        for (std::uint32_t& tet : t.tets) tet = tet == kNone ? kNone : tet + packet.first_tet;
        if (t.tets[1] == kNone)
          halves.push_back({tets::sorted(t.triangle.verts).verts, static_cast<std::uint32_t>(triangles.size())});
        triangles.push_back(t);
      }
    }
    parallel_sort(halves, runner_);
    for (std::size_t i = 0; i + 1 < halves.size(); ++i) {
      if (halves[i].verts != halves[i + 1].verts) continue;
      LinkedTriangle &first = triangles[halves[i].triangle], &second = triangles[halves[i + 1].triangle];
      first.tets[1] = std::exchange(second.tets[0], kNone);
    }
    std::erase_if(triangles, [](const LinkedTriangle& t) { return t.tets[0] == kNone; });
  }

  const TaskRunner& runner_;
  std::vector<Bytes> given_;
  std::vector<Packet> packets_;
  std::vector<std::uint32_t> numbers_;
  RoundShare share_;
};

Dealt deal_share(const WholeMesh& share, std::span<const std::uint32_t> to_part, std::size_t part_count, int ranks) {
  const auto rank_count = static_cast<std::size_t>(ranks);
  Dealt all{to_part, std::vector<std::uint32_t>(share.size()), std::vector<std::uint32_t>(share.size()),
            std::vector<std::vector<std::uint32_t>>(rank_count), std::vector<std::vector<std::uint32_t>>(rank_count)};
  for (std::uint32_t tet = 0; tet < share.size(); ++tet) {
    const std::uint32_t rank = all.to_rank[tet] =
        static_cast<std::uint32_t>(rank_of_part(to_part[tet], part_count, ranks));
    all.to_place[tet] = static_cast<std::uint32_t>(all.tets[rank].size());
    all.tets[rank].push_back(tet);
  }
  for (std::uint32_t t = 0; t < share.triangles.size(); ++t) {
    const auto [one, other] = share.triangles[t].tets;
    if (one != kNone) all.triangles[all.to_rank[one]].push_back(t);
    if (other != kNone && (one == kNone || all.to_rank[other] != all.to_rank[one]))
      all.triangles[all.to_rank[other]].push_back(t);
  }
  return all;
}

std::vector<Bytes> send_tets(WholeMesh& share, ShareLinks& links, GrowingArray<std::uint32_t>& to_part,
                             std::size_t part_count, const SharedWork& work) {
  const int ranks = work.rank_count();
  return work.exchange([&](std::span<MessageWriter> to) {
    Dealt all = deal_share(share, to_part.span(), part_count, ranks);
    all.first = links.first_tets[static_cast<std::size_t>(work.rank())];
    // One after the other on each thread, which needs a place per vertex of the share for all of them.
    const auto threads = static_cast<std::size_t>(work.runner().threads());
    work.runner().for_blocks(to.size(), (to.size() + threads - 1) / threads, [&](std::size_t begin, std::size_t end) {
      Packer packer(share, links, all);
      for (std::size_t r = begin; r < end; ++r) packer.run(static_cast<std::uint32_t>(r), to[r]);
    });
    share = WholeMesh(), to_part.release();
  });
}

// Vertices that may be on other ranks: those of faces that this one has nothing behind. Tets at a vertex that all have
// something behind them there are all that there are.
std::vector<std::uint32_t> find_open_verts(const WholeMesh& mesh) {
  std::vector<std::uint32_t> verts;
  for (const FaceCode face : mesh.faces()) {
    if (mesh.behind(face).valid()) continue;
    const tets::TriangleVerts triangle = tets::verts_of(mesh.to_vert.data(), face);
    verts.insert(verts.end(), triangle.begin(), triangle.end());
  }
  sort_unique(verts);
  return verts;
}

void find_outside_verts(RoundShare& share, const SharedWork& work) {
  const PartId self(static_cast<std::size_t>(work.rank()));
  PerPart<std::vector<OpenVertex>> open(static_cast<std::size_t>(work.rank_count()), std::span(&self, 1));
  work.each([&] {
    for (const std::uint32_t v : find_open_verts(share.mesh)) open.at(self).push_back({share.to_number[v], v});
  });
  share.outside = std::move(find_residence(open, work.ranks(), work.runner()).at(self));
}

}  // namespace

int rank_of_part(std::uint32_t part, std::size_t part_count, int rank_count) {
  return static_cast<int>(std::uint64_t{part} * static_cast<std::uint64_t>(rank_count) / part_count);
}

RoundShare move_tets(WholeMesh& share, ShareLinks& links, GrowingArray<std::uint32_t> to_part, std::size_t part_count,
                     const SharedWork& work) {
  RoundShare moved;
  if (work.rank_count() == 1) {
    moved.mesh = std::move(share), moved.to_part = std::move(to_part);
    moved.vert_count = moved.mesh.points.size();
    return moved;
  }
  std::vector<Bytes> given = send_tets(share, links, to_part, part_count, work);
  work.each([&] {
    moved = Unpacker(std::move(given), work.runner()).run();
    give_back_free_memory();
    moved.vert_count = moved.mesh.points.size();
  });
  find_outside_verts(moved, work);
  return moved;
}

}  // namespace tetloom::adapt
