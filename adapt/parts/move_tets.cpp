#include <algorithm>
#include <array>
#include <utility>

#include "adapt/parts/share.hpp"
#include "core/base/free_memory.hpp"
#include "core/base/lists.hpp"
#include "core/part/adjacency.hpp"
#include "tetloom/tasks.hpp"
#include "threading/parts/tet_packet.hpp"
#include "threading/runtime/parallel_sort.hpp"

namespace tetloom::adapt {

namespace {

// What each rank gets of a share.
struct Dealt {
  std::span<const std::uint32_t> to_part;             // of all tets of the share
  std::vector<std::uint32_t> to_rank, to_place;       // of each the rank it goes to, and its place among those
  std::vector<std::vector<std::uint32_t>> tets;       // per rank
  std::vector<std::vector<std::uint32_t>> triangles;  // per rank: those at its tets
  std::uint32_t self = 0;                             // this rank
};

// One rank's tets for others, each in one message. Vertices are named by their places in the list of those of the
// message.
class Packer {
 public:
  Packer(const WholeMesh& share, const ShareLinks& links, const Dealt& all)
      : share_(share), links_(links), all_(all), packer_(share) {}

  void run(std::uint32_t rank, MessageWriter& writer) {
    rank_ = rank, tets_ = all_.tets[rank];
    packer_.begin(tets_);
    pieces_.clear(), triangles_.clear(), faces_.clear();
    find_faces();
    find_pieces();
    find_triangles();
    writer.reserve(bytes());
    packer_.put(
        writer, [&](std::uint32_t v) { return links_.number_of(v); }, [&](FaceCode face) { return behind(face); });
    writer.put_array(tets_);
    writer.put_array(std::span<const FaceOutside>(faces_));
    writer.put_each(tets_, [&](std::uint32_t tet) { return all_.to_part[tet]; });
    put_verts(writer);
    writer.put_array(std::span<const ModelEdgePiece>(pieces_));
    writer.put_array(std::span<const LinkedTriangle>(triangles_));
  }

 private:
  static constexpr std::size_t kBytesOfTet = 11 * sizeof(std::uint32_t);
  static constexpr std::size_t kBytesOfVert =
      sizeof(Number) + sizeof(Vec3) + sizeof(VertexMetric) + sizeof(PackedEntity) + sizeof(BackgroundTet) + 1;

  // A little more than it takes.
  std::size_t bytes() const {
    constexpr std::size_t kLengths = 512;
    return kLengths + tets_.size() * kBytesOfTet + packer_.verts().size() * kBytesOfVert +
           pieces_.size() * sizeof(ModelEdgePiece) + triangles_.size() * sizeof(LinkedTriangle) +
           faces_.size() * sizeof(FaceOutside);
  }

  FaceCode behind(FaceCode face) const {
    const FaceCode behind = share_.behind(face);
    const bool is_here = behind.valid() && all_.to_rank[behind.tet()] == rank_;
    return is_here ? behind.of_tet(all_.to_place[behind.tet()]) : FaceCode();
  }

  // Those with something behind them that is in no message from here to there, by places in the message.
  void find_faces() {
    for (std::uint32_t place = 0; place < tets_.size(); ++place) {
      for (const FaceCode face : FaceCode::of(tets_[place])) {
        const FaceCode behind = share_.behind(face);
        const RemoteFace outside = behind.valid() ? RemoteFace{all_.self, behind} : links_.behind(face);
        const bool is_here = behind.valid() && all_.to_rank[behind.tet()] == rank_;
        if (outside.valid() && !is_here) faces_.push_back({face.of_tet(place), outside});
      }
    }
  }

  void put_verts(MessageWriter& writer) const {
    writer.put_each(packer_.verts(), [&](std::uint32_t v) { return share_.to_metric[v]; });
    writer.put_each(packer_.verts(), [&](std::uint32_t v) { return share_.to_entity[v]; });
    writer.put_each(packer_.verts(), [&](std::uint32_t v) { return share_.to_hint[v]; });
    writer.put_each(packer_.verts(), [&](std::uint32_t v) { return share_.to_state[v]; });
  }

  void find_pieces() {
    for (const std::uint32_t tet : tets_)
      for_each_piece(share_, tet, [&](const ModelEdgePiece& piece) { pieces_.push_back(piece); });
    sort_pieces(pieces_);
    for (ModelEdgePiece& piece : pieces_)
      for (std::uint32_t& v : piece.verts) v = packer_.place_of(v);
  }

  // With those of their tets that are in the message.
  void find_triangles() {
    for (const std::uint32_t triangle : all_.triangles[rank_]) {
      LinkedTriangle t = share_.triangles[triangle];
      for (std::uint32_t& tet : t.tets) tet = tet != kNone && all_.to_rank[tet] == rank_ ? all_.to_place[tet] : kNone;
      if (t.tets[0] == kNone) std::swap(t.tets[0], t.tets[1]);
      for (std::uint32_t& v : t.triangle.verts) v = packer_.place_of(v);
      triangles_.push_back(t);
    }
  }

  const WholeMesh& share_;
  const ShareLinks& links_;
  const Dealt& all_;
  std::uint32_t rank_ = 0;
  std::span<const std::uint32_t> tets_;
  TetPacker<WholeMesh> packer_;
  std::vector<FaceOutside> faces_;
  std::vector<ModelEdgePiece> pieces_;
  std::vector<LinkedTriangle> triangles_;
};

// What stands behind the tets in one rank's message, where it lies.
struct Beside {
  explicit Beside(MessageReader& reader) {
    from = reader.get_view<std::uint32_t>(), faces = reader.get_view<FaceOutside>(),
    parts = reader.get_view<std::uint32_t>();
    to_metric = reader.get_view<VertexMetric>(), to_entity = reader.get_view<PackedEntity>();
    to_hint = reader.get_view<BackgroundTet>(), to_state = reader.get_view<std::uint8_t>();
    edges = reader.get_view<ModelEdgePiece>(), triangles = reader.get_view<LinkedTriangle>();
  }

  std::span<const std::uint32_t> from, parts;
  std::span<const BackgroundTet> to_hint;  // `from`: tets as the sender names them, ascending
  std::span<const FaceOutside> faces;      // by places in the message, and what lies behind them
  std::span<const VertexMetric> to_metric;
  std::span<const PackedEntity> to_entity;
  std::span<const std::uint8_t> to_state;
  std::span<const ModelEdgePiece> edges;
  std::span<const LinkedTriangle> triangles;
};

// The tets of all packets, which are ascending in number: so ranks have numbered them. Packets are freed on the way.
class Unpacker {
 public:
  Unpacker(std::vector<Bytes>&& given, const TaskRunner& runner) : runner_(runner), packets_(std::move(given)) {
    share_.to_part.reserve(packets_.tet_count());
    for (TetPacket& packet : packets_.all()) {
      const Beside& beside = beside_.emplace_back(packet.rest);
      share_.to_part.append(beside.parts);
    }
  }

  RoundShare run() {
    take_verts();
    take_edges();
    take_triangles();
    find_links();
    packets_.move_tets_into(share_.mesh, runner_, [](const TetPacket& packet, FaceCode face) {
      return face.of_tet(face.tet() + packet.first_tet);
    });
    for (const auto& [face, behind] : links_) share_.mesh.behind(face) = behind;
    return std::move(share_);
  }

 private:
  // Several packets may have a vertex, the same in all.
  void take_verts() {
    WholeMesh& mesh = share_.mesh;
    packets_.number_verts(runner_, [&](std::uint64_t number, std::uint32_t p, std::uint32_t i, bool is_new) {
      if (!is_new) return;
      share_.to_number.push_back(number);
      mesh.points.push_back(packets_.all()[p].points[i]);
      mesh.to_metric.push_back(beside_[p].to_metric[i]), mesh.to_entity.push_back(beside_[p].to_entity[i]);
      mesh.to_hint.push_back(beside_[p].to_hint[i]), mesh.to_state.push_back(beside_[p].to_state[i]);
    });
  }

  // Between tets of two packets.
  void find_links() {
    for (std::size_t p = 0; p < beside_.size(); ++p) {
      for (const FaceOutside& one : beside_[p].faces) {
        const auto& from = beside_[one.behind.rank].from;
        const auto at = std::ranges::lower_bound(from, one.behind.face.tet());
        if (at == from.end() || *at != one.behind.face.tet()) continue;
        const auto tet = packets_.all()[one.behind.rank].first_tet + static_cast<std::uint32_t>(at - from.begin());
        links_.emplace_back(one.face.of_tet(one.face.tet() + packets_.all()[p].first_tet), one.behind.face.of_tet(tet));
      }
    }
  }

  void take_edges() {
    for (std::size_t p = 0; p < beside_.size(); ++p) {
      for (ModelEdgePiece piece : beside_[p].edges) {
        for (std::uint32_t& v : piece.verts) v = packets_.all()[p].to_local[v];
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
    for (std::size_t p = 0; p < beside_.size(); ++p) {
      const TetPacket& packet = packets_.all()[p];
      for (LinkedTriangle t : beside_[p].triangles) {
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
  TetPackets packets_;
  std::vector<Beside> beside_;  // per packet
  std::vector<std::pair<FaceCode, FaceCode>> links_;
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
    all.self = static_cast<std::uint32_t>(work.rank());
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
