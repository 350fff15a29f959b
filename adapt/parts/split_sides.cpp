#include "adapt/parts/split_sides.hpp"

#include <algorithm>

namespace tetloom::adapt {

namespace {

constexpr int kSweeps = 3;

// What a rank says of an edge.
struct Named {
  std::array<Number, 2> ends;
  PackedEntity entity;
  std::uint32_t refused = 0;
};

// An edge that parts of this rank have.
struct OwnEdge {
  std::array<std::uint32_t, 2> ends;  // vertices of the share
  PackedEntity entity;
  bool refused = false;
  std::uint32_t vert = kNone;  // of the share, where it is split
};

void keep_lowest(PackedEntity& entity, PackedEntity other) {
  if (other.unpack().dim < entity.unpack().dim) entity = other;
}

class SideSplitter {
 public:
  SideSplitter(RoundShare& share, const ShareLinks& links, std::span<PartOfWhole> parts, const RoundWork& round,
               const SharedWork& work)
      : share_(share),
        parts_(parts),
        source_(*round.source),
        options_(round.sides),
        tiles_(round.tiles),
        work_(work),
        next_number_(links.first_verts.back()),
        edges_(parts.size()) {}

  std::size_t run() {
    for (int sweep = 0; sweep < kSweeps; ++sweep) {
      work_.each([&] { find(); });
      if (!agree()) break;
      look_up();
      work_.each([&] { split(); });
    }
    return split_count_;
  }

 private:
  Number number_of(std::uint32_t vert) const { return share_.to_number.empty() ? vert : share_.to_number[vert]; }

  void find() {
    work_.runner().for_each(parts_.size(), [&](std::size_t p) {
      edges_[p] = SideSplits(parts_[p].mesh, parts_[p].to_whole.span(), source_, options_).find();
    });
    own_.clear();
    for (const std::vector<SideEdge>& edges : edges_)
      for (const SideEdge& edge : edges) own_.push_back({edge.names, edge.entity, edge.refused});
    std::ranges::stable_sort(own_, {}, &OwnEdge::ends);
    std::size_t kept = 0;
    for (std::size_t i = 0; i < own_.size(); ++i) {
      if (kept > 0 && own_[kept - 1].ends == own_[i].ends) {
        own_[kept - 1].refused |= own_[i].refused;
        keep_lowest(own_[kept - 1].entity, own_[i].entity);
      } else {
        own_[kept++] = own_[i];
      }
    }
    own_.resize(kept);
  }

  // Whether any edge is split. New vertices have the numbers after all others, in the order of the edges.
  bool agree() {
    const std::vector<Bytes> told = work_.all_gather([&](MessageWriter& writer) {
      writer.put_each(own_, [&](const OwnEdge& edge) {
        return Named{{number_of(edge.ends[0]), number_of(edge.ends[1])}, edge.entity, edge.refused};
      });
    });
    std::vector<std::span<const Named>> rest;  // of what each rank says
    std::vector<MessageReader> readers(told.begin(), told.end());
    for (MessageReader& reader : readers) rest.push_back(reader.get_view<Named>());
    const Number before = next_number_;
    auto own = own_.begin();
    for (;;) {
      std::array<Number, 2> ends{kNoNumber, kNoNumber};
      for (const auto& edges : rest)
        if (!edges.empty()) ends = std::min(ends, edges.front().ends);
      if (ends[0] == kNoNumber) break;
      Named all{ends, PackedEntity(ModelEntity(3, 0)), 0};
      ranks_.clear();
      take(rest, all);
      const bool is_own = std::ranges::binary_search(ranks_, static_cast<std::uint32_t>(work_.rank()));
      if (all.refused == 0) {
        if (is_own) add_vert(*own, all.entity);
        ++next_number_;
      }
      own += is_own;
    }
    return next_number_ > before;
  }

  // What all ranks say of the edge that is the next one.
  void take(std::vector<std::span<const Named>>& rest, Named& all) {
    for (std::uint32_t rank = 0; rank < rest.size(); ++rank) {
      if (rest[rank].empty() || rest[rank].front().ends != all.ends) continue;
      const Named& one = rest[rank].front();
      if (ranks_.empty()) all.entity = one.entity;
      keep_lowest(all.entity, one.entity), all.refused |= one.refused;
      ranks_.push_back(rank);
      rest[rank] = rest[rank].subspan(1);
    }
  }

  void add_vert(OwnEdge& edge, PackedEntity entity) {
    const auto self = static_cast<std::uint32_t>(work_.rank());
    edge.vert = static_cast<std::uint32_t>(share_.vert_count++);
    edge.entity = entity;
    split_count_ += ranks_.front() == self;
    if (work_.rank_count() == 1) return;
    share_.to_number.push_back(next_number_);
    if (ranks_.size() == 1) return;
    share_.outside.verts.push_back(edge.vert);
    for (const std::uint32_t rank : ranks_)
      if (rank != self) share_.outside.parts.push_back(PartId(rank));
    share_.outside.first.push_back(static_cast<std::uint32_t>(share_.outside.parts.size()));
  }

  const OwnEdge& own_of(const SideEdge& edge) const {
    return *std::ranges::lower_bound(own_, edge.names, {}, &OwnEdge::ends);
  }

  // Where the ends of edges that are split are looked up.
  std::vector<std::uint32_t> tiles_at_edges() const {
    std::vector<std::uint32_t> tiles;
    for (std::size_t p = 0; p < parts_.size(); ++p)
      for (const SideEdge& edge : edges_[p])
        if (own_of(edge).vert != kNone)
          for (const std::uint32_t v : edge.ends) tiles.push_back(tiles_->tile_of(parts_[p].mesh.to_hint[v]));
    return tiles;
  }

  // What the vertices to be are like.
  void look_up() {
    spots_.assign(parts_.size(), {});
    if (tiles_ != nullptr) tiles_->fetch_only(tiles_at_edges(), work_);
    until_found(tiles_, work_, [&] {
      work_.runner().for_each(parts_.size(), [&](std::size_t p) {
        const SideSplits splits(parts_[p].mesh, parts_[p].to_whole.span(), source_, options_);
        // Where tiles are missing, from the same edge on, once they are there.
        finds(tiles_, [&] {
          for (std::size_t i = spots_[p].size(); i < edges_[p].size(); ++i)
            spots_[p].push_back(own_of(edges_[p][i]).vert == kNone ? SideSpot() : splits.spot(edges_[p][i]));
        });
      });
    });
  }

  void split() {
    work_.runner().for_each(parts_.size(), [&](std::size_t p) {
      SideSplits splits(parts_[p].mesh, parts_[p].to_whole.span(), source_, options_);
      for (std::size_t i = 0; i < edges_[p].size(); ++i) {
        const OwnEdge& own = own_of(edges_[p][i]);
        if (own.vert == kNone) continue;
        splits.split(edges_[p][i], own.entity, spots_[p][i]);
        parts_[p].to_whole.push_back(own.vert);
      }
    });
  }

  RoundShare& share_;
  std::span<PartOfWhole> parts_;
  const MetricStage& source_;
  const SideSplitOptions& options_;
  BackgroundTiles* tiles_;
  const SharedWork& work_;
  Number next_number_;
  std::vector<std::vector<SideEdge>> edges_;  // of each part
  std::vector<std::vector<SideSpot>> spots_;  // of each edge of each part
  std::vector<OwnEdge> own_;                  // ascending
  std::vector<std::uint32_t> ranks_;          // that have the edge at hand
  std::size_t split_count_ = 0;
};

}  // namespace

std::size_t split_sides(RoundShare& share, const ShareLinks& links, std::span<PartOfWhole> parts,
                        const RoundWork& round, const SharedWork& work) {
  return SideSplitter(share, links, parts, round, work).run();
}

}  // namespace tetloom::adapt
