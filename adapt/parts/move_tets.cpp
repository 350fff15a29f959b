#include <algorithm>
#include <array>
#include <utility>

#include "adapt/parts/share.hpp"
#include "core/base/free_memory.hpp"
#include "core/base/lists.hpp"
#include "tetloom/tasks.hpp"
#include "threading/parts/tet_packet.hpp"
#include "threading/runtime/parallel_sort.hpp"

namespace tetloom::adapt {

namespace {

// What each rank gets of a share.
struct Dealt {
  std::span<const std::uint32_t> to_part;             // of all tets of the share
  std::vector<std::vector<std::uint32_t>> tets;       // per rank, ascending
  std::vector<std::vector<std::uint32_t>> triangles;  // per rank: those at its tets
  std::vector<std::uint8_t> is_open;                  // per vertex: whether several ranks may get it
};

// One rank's tets for others, each in one message. Vertices are named by their places in the list of those of the
// message.
class Packer {
 public:
  Packer(const WholeMesh& share, const ShareLinks& links, const Dealt& all)
      : share_(share), links_(links), all_(all), packer_(share) {}

  void run(std::uint32_t rank, MessageWriter& writer) {
    tets_ = all_.tets[rank];
    packer_.begin(tets_);
    pieces_.clear(), triangles_.clear(), open_.clear();
    find_open();
    find_pieces();
    find_triangles(rank);
    writer.reserve(bytes());
    packer_.put(writer, [&](std::uint32_t v) { return links_.number_of(v); });
    writer.put_each(tets_, [&](std::uint32_t tet) { return all_.to_part[tet]; });
    put_verts(writer);
    writer.put_array(std::span<const std::uint32_t>(open_));
    writer.put_array(std::span<const ModelEdgePiece>(pieces_));
    writer.put_array(std::span<const LinkedTriangle>(triangles_));
  }

 private:
  static constexpr std::size_t kBytesOfTet = 6 * sizeof(std::uint32_t);
  static constexpr std::size_t kBytesOfVert =
      sizeof(Number) + sizeof(Vec3) + sizeof(VertexMetric) + sizeof(PackedEntity) + sizeof(BackgroundTet) + 1;

  // A little more than it takes.
  std::size_t bytes() const {
    constexpr std::size_t kLengths = 512;
    return kLengths + tets_.size() * kBytesOfTet + packer_.verts().size() * kBytesOfVert +
           open_.size() * sizeof(std::uint32_t) + pieces_.size() * sizeof(ModelEdgePiece) +
           triangles_.size() * sizeof(LinkedTriangle);
  }

  void put_verts(MessageWriter& writer) const {
    writer.put_each(packer_.verts(), [&](std::uint32_t v) { return share_.to_metric[v]; });
    writer.put_each(packer_.verts(), [&](std::uint32_t v) { return share_.to_entity[v]; });
    writer.put_each(packer_.verts(), [&](std::uint32_t v) { return share_.to_hint[v]; });
    writer.put_each(packer_.verts(), [&](std::uint32_t v) { return share_.to_state[v]; });
  }

  void find_open() {
    const auto verts = packer_.verts();
    for (std::uint32_t place = 0; place < verts.size(); ++place)
      if (all_.is_open[verts[place]] != 0) open_.push_back(place);
  }

  void find_pieces() {
    for (const std::uint32_t tet : tets_)
      for_each_piece(share_, tet, [&](const ModelEdgePiece& piece) { pieces_.push_back(piece); });
    sort_pieces(pieces_);
    for (ModelEdgePiece& piece : pieces_)
      for (std::uint32_t& v : piece.verts) v = packer_.place_of(v);
  }

  // With those of their tets that are in the message.
  void find_triangles(std::uint32_t rank) {
    for (const std::uint32_t triangle : all_.triangles[rank]) {
      LinkedTriangle t = share_.triangles[triangle];
      for (std::uint32_t& tet : t.tets) tet = place_in_message(tet);
      if (t.tets[0] == kNone) std::swap(t.tets[0], t.tets[1]);
      for (std::uint32_t& v : t.triangle.verts) v = packer_.place_of(v);
      triangles_.push_back(t);
    }
  }

  std::uint32_t place_in_message(std::uint32_t tet) const {
    const auto at = std::ranges::lower_bound(tets_, tet);
    return at == tets_.end() || *at != tet ? kNone : static_cast<std::uint32_t>(at - tets_.begin());
  }

  const WholeMesh& share_;
  const ShareLinks& links_;
  const Dealt& all_;
  std::span<const std::uint32_t> tets_;
  TetPacker<WholeMesh> packer_;
  std::vector<std::uint32_t> open_;  // places of vertices
  std::vector<ModelEdgePiece> pieces_;
  std::vector<LinkedTriangle> triangles_;
};

// What stands behind the tets in one rank's message, where it lies.
struct Beside {
  explicit Beside(MessageReader& reader) {
    parts = reader.get_view<std::uint32_t>();
    to_metric = reader.get_view<VertexMetric>(), to_entity = reader.get_view<PackedEntity>();
    to_hint = reader.get_view<BackgroundTet>(), to_state = reader.get_view<std::uint8_t>();
    open = reader.get_view<std::uint32_t>();
    edges = reader.get_view<ModelEdgePiece>(), triangles = reader.get_view<LinkedTriangle>();
  }

  std::span<const std::uint32_t> parts;
  std::span<const VertexMetric> to_metric;
  std::span<const PackedEntity> to_entity;
  std::span<const BackgroundTet> to_hint;
  std::span<const std::uint8_t> to_state;
  std::span<const std::uint32_t> open;
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

  /// `open`: vertices that other ranks may have as well, ascending.
  RoundShare run(std::vector<std::uint32_t>& open) {
    take_verts();
    for (std::size_t p = 0; p < beside_.size(); ++p)
      for (const std::uint32_t place : beside_[p].open) open.push_back(packets_.all()[p].to_local[place]);
    sort_unique(open);
    take_edges();
    take_triangles();
    packets_.move_tets_into(share_.mesh, runner_);
    return std::move(share_);
  }

 private:
  // Several packets may have a vertex, the same in all.
  void take_verts() {
    WholeMesh& mesh = share_.mesh;
    packets_.number_verts(runner_, [&](std::uint64_t number, std::uint32_t p, std::uint32_t i, bool is_new) {
      if (!is_new) return;
      share_.to_number.push_back(number);
      mesh.points.push_back(packets_.all()[p].verts.points[i]);
      mesh.to_metric.push_back(beside_[p].to_metric[i]), mesh.to_entity.push_back(beside_[p].to_entity[i]);
      mesh.to_hint.push_back(beside_[p].to_hint[i]), mesh.to_state.push_back(beside_[p].to_state[i]);
    });
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

  void take_triangles() {
    for (std::size_t p = 0; p < beside_.size(); ++p) {
      const TetPacket& packet = packets_.all()[p];
      for (LinkedTriangle t : beside_[p].triangles) {
        for (std::uint32_t& v : t.triangle.verts) v = packet.to_local[v];
        for (std::uint32_t& tet : t.tets) tet = tet == kNone ? kNone : tet + packet.first_tet;
        share_.mesh.triangles.push_back(t);
      }
    }
  }

  const TaskRunner& runner_;
  TetPackets packets_;
  std::vector<Beside> beside_;  // per packet
  RoundShare share_;
};

// Vertices of tets that go to several ranks, and those that other ranks have now.
std::vector<std::uint8_t> find_open(const WholeMesh& share, const ShareLinks& links, const Dealt& all) {
  std::vector<std::uint8_t> is_open(share.points.size(), 0);
  for (const std::uint32_t v : links.shared) is_open[v] = 1;
  std::vector<std::uint32_t> to_rank(share.points.size(), kNone);
  for (std::uint32_t rank = 0; rank < all.tets.size(); ++rank) {
    for (const std::uint32_t tet : all.tets[rank]) {
      for (std::size_t i = 0; i < 4; ++i) {
        const std::uint32_t v = share.to_vert[std::size_t{tet} * 4 + i];
        if (to_rank[v] == kNone) to_rank[v] = rank;
        if (to_rank[v] != rank) is_open[v] = 1;
      }
    }
  }
  return is_open;
}

Dealt deal_share(const WholeMesh& share, const ShareLinks& links, std::span<const std::uint32_t> to_part,
                 std::size_t part_count, int ranks) {
  const auto rank_count = static_cast<std::size_t>(ranks);
  Dealt all{to_part,
            std::vector<std::vector<std::uint32_t>>(rank_count),
            std::vector<std::vector<std::uint32_t>>(rank_count),
            {}};
  const auto rank_of = [&](std::uint32_t tet) {
    return static_cast<std::size_t>(rank_of_part(to_part[tet], part_count, ranks));
  };
  for (std::uint32_t tet = 0; tet < share.size(); ++tet) all.tets[rank_of(tet)].push_back(tet);
  for (std::uint32_t t = 0; t < share.triangles.size(); ++t) {
    const auto [one, other] = share.triangles[t].tets;
    all.triangles[rank_of(one)].push_back(t);
    if (other != kNone && rank_of(other) != rank_of(one)) all.triangles[rank_of(other)].push_back(t);
  }
  all.is_open = find_open(share, links, all);
  return all;
}

std::vector<Bytes> send_tets(WholeMesh& share, ShareLinks& links, GrowingArray<std::uint32_t>& to_part,
                             std::size_t part_count, const SharedWork& work) {
  const int ranks = work.rank_count();
  return work.exchange([&](std::span<MessageWriter> to) {
    const Dealt all = deal_share(share, links, to_part.span(), part_count, ranks);
    // One after the other on each thread, which needs a place per vertex of the share for all of them.
    const auto threads = static_cast<std::size_t>(work.runner().threads());
    work.runner().for_blocks(to.size(), (to.size() + threads - 1) / threads, [&](std::size_t begin, std::size_t end) {
      Packer packer(share, links, all);
      for (std::size_t r = begin; r < end; ++r) packer.run(static_cast<std::uint32_t>(r), to[r]);
    });
    share = WholeMesh(), to_part.release();
  });
}

void find_outside_verts(RoundShare& share, std::span<const std::uint32_t> open_verts, const SharedWork& work) {
  const PartId self(static_cast<std::size_t>(work.rank()));
  PerPart<std::vector<OpenVertex>> open(static_cast<std::size_t>(work.rank_count()), std::span(&self, 1));
  work.each([&] {
    for (const std::uint32_t v : open_verts) open.at(self).push_back({share.to_number[v], v});
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
  std::vector<std::uint32_t> open_verts;
  work.each([&] {
    moved = Unpacker(std::move(given), work.runner()).run(open_verts);
    give_back_free_memory();
    moved.vert_count = moved.mesh.points.size();
  });
  find_outside_verts(moved, open_verts, work);
  return moved;
}

}  // namespace tetloom::adapt
