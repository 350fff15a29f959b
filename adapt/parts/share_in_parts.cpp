#include "adapt/parts/share_in_parts.hpp"

#include <algorithm>
#include <array>
#include <unordered_map>
#include <utility>

#include "core/base/lists.hpp"
#include "core/part/adjacency.hpp"

namespace tetloom::adapt {

namespace {

// Numbers of vertices once umbrellas that touch have one vertex again: that of the first umbrella.
class JoinedNumbers {
 public:
  JoinedNumbers(const SharePieces& pieces, const SharedWork& work) : pieces_(pieces) {
    if (pieces.touching.to_entity.empty()) return;
    const std::vector<Bytes> given = work.all_gather([&](MessageWriter& writer) {
      std::vector<Named> own;
      for (std::uint32_t v = 0; v < pieces.share.points.size(); ++v)
        if (slot_of(v) != kNone) own.push_back({slot_of(v), 0, pieces.links.number_of(v)});
      writer.put_array(std::span<const Named>(own));
    });
    work.each([&] { take(given); });
  }

  std::uint64_t of(std::uint32_t vert) const {
    const std::uint32_t slot = slot_of(vert);
    const Number number = slot == kNone ? pieces_.links.number_of(vert) : first_[slot];
    return number - pieces_.links.first_verts.front() -
           static_cast<Number>(std::ranges::lower_bound(dropped_, number) - dropped_.begin());
  }

  PackedEntity entity_of(std::uint32_t vert) const {
    const std::uint32_t slot = slot_of(vert);
    return slot == kNone ? pieces_.share.to_entity[vert] : pieces_.touching.to_entity[slot];
  }

 private:
  struct Named {
    std::uint32_t slot = kNone, padding = 0;
    Number number = kNoNumber;
    auto operator<=>(const Named&) const = default;
  };

  // Its place among the vertices at which umbrellas touch.
  std::uint32_t slot_of(std::uint32_t vert) const {
    if (pieces_.touching.to_entity.empty()) return kNone;
    const ModelEntity entity = pieces_.share.to_entity[vert].unpack();
    const bool touches = entity.valid() && entity.dim == 0 && entity.index >= pieces_.touching.first;
    return touches ? entity.index - pieces_.touching.first : kNone;
  }

  void take(const std::vector<Bytes>& given) {
    std::vector<Named> all = joined_lists<Named>(given);
    sort_unique(all);
    first_.assign(pieces_.touching.to_entity.size(), kNoNumber);
    for (const Named& one : all) {
      if (first_[one.slot] == kNoNumber)
        first_[one.slot] = one.number;
      else
        dropped_.push_back(one.number);
    }
    std::ranges::sort(dropped_);
  }

  const SharePieces& pieces_;
  std::vector<Number> first_;    // of the first umbrella's vertex, by slot
  std::vector<Number> dropped_;  // numbers of those of other umbrellas, ascending
};

// How large tables of entities have to be: corners and edges that the source does not name are beyond them.
struct TableSizes {
  std::array<std::size_t, 4> counts{};

  TableSizes(const SharePieces& pieces, const JoinedNumbers& numbers, const SharedWork& work) {
    for (std::size_t dim = 0; dim < 4; ++dim) counts[dim] = pieces.source.entities[dim].size();
    std::array<double, 2> most{0, 0};
    work.each([&] {
      for (std::uint32_t v = 0; v < pieces.share.points.size(); ++v) note(numbers.entity_of(v).unpack(), most);
      for (const ModelEdgePiece& piece : pieces.share.edges) note(ModelEntity(1, piece.edge & ~kTouching), most);
    });
    work.max(most);
    for (std::size_t dim = 0; dim < 2; ++dim)
      if (counts[dim] > 0) counts[dim] = std::max(counts[dim], static_cast<std::size_t>(most[dim]));
    counts[2] = std::max(counts[2], pieces.source.face_to_sides.size());
  }

  static void note(ModelEntity entity, std::array<double, 2>& most) {
    if (!entity.valid() || entity.dim > 1) return;
    double& count = most[static_cast<std::size_t>(entity.dim)];
    count = std::max(count, static_cast<double>(entity.index) + 1);
  }
};

// One part, out of the share that has it.
class PartMaker {
 public:
  PartMaker(const SharePieces& pieces, const JoinedNumbers& numbers, const TableSizes& tables, std::size_t part)
      : pieces_(pieces),
        share_(pieces.share),
        numbers_(numbers),
        tables_(tables),
        first_tet_(pieces.links.part_tets[part]),
        last_tet_(pieces.links.part_tets[part + 1]),
        first_vert_(pieces.links.part_verts[part]),
        last_vert_(pieces.links.part_verts[part + 1]) {}

  PartMesh run(std::span<const std::uint32_t> triangles, GrowingArray<VertexMetric>& to_metric) {
    take_tets();
    take_verts(to_metric);
    connect_cells(part_);
    take_triangles(triangles);
    take_edges();
    take_fields();
    take_entities();
    return std::move(part_);
  }

 private:
  // Vertices of the part's own stand as they do in the share; those of lower parts follow as tets use them. Vertices
  // that umbrellas have made of one are one again.
  std::uint32_t local_of(std::uint32_t vert) {
    const auto at = others_.find(vert);
    if (at != others_.end()) return at->second;
    const auto next = static_cast<std::uint32_t>(verts_.size());
    const auto [same, is_new] = by_number_.emplace(numbers_.of(vert), next);
    if (is_new) verts_.push_back(vert);
    others_.emplace(vert, same->second);
    return same->second;
  }

  bool is_own(std::uint32_t vert) const { return vert >= first_vert_ && vert < last_vert_; }
  std::uint32_t known(std::uint32_t vert) const {
    if (is_own(vert) && !has_umbrellas()) return vert - static_cast<std::uint32_t>(first_vert_);
    const auto at = others_.find(vert);
    return at == others_.end() ? to_local_[vert - first_vert_] : at->second;
  }
  bool has_umbrellas() const { return !pieces_.touching.to_entity.empty(); }

  void take_tets() {
    number_own();
    CellBlock& block = part_.block(CellKind::Tet);
    block.to_vert.reserve((last_tet_ - first_tet_) * 4);
    for (std::size_t i = first_tet_ * 4; i < last_tet_ * 4; ++i) {
      const std::uint32_t vert = share_.to_vert[i];
      block.to_vert.push_back(is_own(vert) ? known(vert) : local_of(vert));
    }
    block.to_region.append(share_.to_region.span().subspan(first_tet_, last_tet_ - first_tet_));
  }

  void number_own() {
    for (std::size_t i = first_vert_; i < last_vert_; ++i) {
      const auto vert = static_cast<std::uint32_t>(i);
      if (!has_umbrellas()) {
        verts_.push_back(vert);
        continue;
      }
      // Only vertices at which umbrellas touch have numbers that others have as well.
      const bool touches = numbers_.entity_of(vert) != share_.to_entity[vert];
      to_local_.push_back(touches ? local_of(vert) : static_cast<std::uint32_t>(verts_.size()));
      if (!touches) verts_.push_back(vert);
    }
  }

  void take_verts(GrowingArray<VertexMetric>& to_metric) {
    part_.points.reserve(verts_.size()), to_metric.reserve(verts_.size());
    for (const std::uint32_t v : verts_) {
      part_.points.push_back(share_.points[v]);
      part_.vert_to_entity.push_back(numbers_.entity_of(v));
      part_.vert_to_global.push_back(numbers_.of(v));
      to_metric.push_back(share_.to_metric[v]);
    }
  }

  // By their numbers, from the lowest vertex on: two parts that have a triangle list it alike.
  void take_triangles(std::span<const std::uint32_t> triangles) {
    struct Numbered {
      std::array<std::uint64_t, 3> numbers;  // of the triangle's vertices, the lowest first
      SurfaceTriangle triangle;
    };
    std::vector<Numbered> all;
    for (const std::uint32_t i : triangles) {
      Numbered& one = all.emplace_back(Numbered{{}, share_.triangles[i].triangle});
      for (std::uint32_t& v : one.triangle.verts) v = known(v);
      const auto number_of = [&](std::uint32_t v) { return part_.vert_to_global[v]; };
      auto& verts = one.triangle.verts;
      std::ranges::rotate(verts, std::ranges::min_element(verts, {}, number_of));
      std::ranges::transform(verts, one.numbers.begin(), number_of);
    }
    std::ranges::sort(all, {}, &Numbered::numbers);
    BoundaryBlock& block = part_.block(BoundaryKind::Triangle);
    for (const Numbered& one : all) {
      block.to_vert.append(std::span<const std::uint32_t>(one.triangle.verts));
      block.to_entity.push_back(one.triangle.face);
    }
  }

  void take_edges() {
    std::vector<ModelEdgePiece> pieces;
    for (std::size_t tet = first_tet_; tet < last_tet_; ++tet)
      for_each_piece(share_, static_cast<std::uint32_t>(tet), [&](const ModelEdgePiece& piece) {
        const std::uint32_t a = known(piece.verts[0]), b = known(piece.verts[1]);
        pieces.push_back({{std::min(a, b), std::max(a, b)}, piece.edge & ~kTouching});
      });
    sort_pieces(pieces);
    BoundaryBlock& block = part_.block(BoundaryKind::Edge);
    // From the lower to the higher end, as in the whole mesh.
    for (ModelEdgePiece& piece : pieces) {
      if (part_.vert_to_global[piece.verts[0]] > part_.vert_to_global[piece.verts[1]])
        std::swap(piece.verts[0], piece.verts[1]);
      block.to_vert.append(std::span<const std::uint32_t>(piece.verts));
      block.to_entity.push_back(piece.edge);
    }
  }

  static std::size_t components_of(const ShareFields& fields) {
    std::size_t all = 0;
    for (const FieldInfo& info : fields.infos) all += static_cast<std::size_t>(info.components);
    return all;
  }

  // Calls put(field, values) for the items in turn.
  template <class Items, class Put>
  static void for_each_value(const ShareFields& fields, const Items& items, const Put& put) {
    const std::size_t all = components_of(fields);
    std::size_t first = 0;
    for (std::size_t f = 0; f < fields.infos.size(); ++f) {
      const auto n = static_cast<std::size_t>(fields.infos[f].components);
      for (const auto item : items) put(f, fields.values.subspan(std::size_t{item} * all + first, n));
      first += n;
    }
  }

  void take_fields() {
    for (const FieldInfo& info : pieces_.on_points.infos)
      part_.vertex_fields.push_back({info.name, info.components, {}});
    for_each_value(pieces_.on_points, verts_, [&](std::size_t f, std::span<const double> values) {
      part_.vertex_fields[f].values.append(values);
    });
    std::vector<std::size_t> tets;
    for (std::size_t tet = first_tet_; tet < last_tet_ && !pieces_.on_tets.infos.empty(); ++tet) tets.push_back(tet);
    for (const FieldInfo& info : pieces_.on_tets.infos) part_.cell_fields.push_back({info.name, info.components, {}});
    for_each_value(pieces_.on_tets, tets, [&](std::size_t f, std::span<const double> values) {
      part_.cell_fields[f].values[static_cast<std::size_t>(CellKind::Tet)].append(values);
    });
  }

  // Those that something of the part lies on, as far as the tables reach.
  void take_entities() {
    std::vector<PackedEntity> used;
    const auto note = [&](PackedEntity entity) {
      if (used.empty() || used.back() != entity) used.push_back(entity);
    };
    for (const PackedEntity entity : part_.vert_to_entity) note(entity);
    const auto note_all = [&](int dim, const GrowingArray<std::uint32_t>& entities) {
      for (const std::uint32_t entity : entities)
        if (entity != kNone) note(PackedEntity(ModelEntity(dim, entity)));
    };
    note_all(1, part_.block(BoundaryKind::Edge).to_entity), note_all(2, part_.block(BoundaryKind::Triangle).to_entity);
    note_all(3, part_.block(CellKind::Tet).to_region);
    sort_unique(used);
    for (const PackedEntity entity : used) add_entity(entity.unpack());
  }

  void add_entity(ModelEntity entity) {
    if (!entity.valid() || entity.index >= tables_.counts[entity.dim]) return;
    const auto& attributes = pieces_.source.entities[entity.dim];
    PartEntity& made = part_.entities.emplace_back();
    made.entity = entity;
    made.has_attributes = !attributes.empty() && (entity.dim < 2 || entity.index < attributes.size());
    if (entity.index < attributes.size()) made.attributes = attributes[entity.index];
    if (entity.dim == 2 && entity.index < pieces_.source.face_to_sides.size())
      made.sides = pieces_.source.face_to_sides[entity.index];
  }

  const SharePieces& pieces_;
  const WholeMesh& share_;
  const JoinedNumbers& numbers_;
  const TableSizes& tables_;
  std::size_t first_tet_, last_tet_, first_vert_, last_vert_;
  PartMesh part_;
  std::vector<std::uint32_t> verts_;     // of the share, by those of the part
  std::vector<std::uint32_t> to_local_;  // of the part's own vertices, where some are one with others
  // Of other vertices; never walked through.
  std::unordered_map<std::uint32_t, std::uint32_t> others_;
  std::unordered_map<std::uint64_t, std::uint32_t> by_number_;
};

// The triangles of each part of this rank.
std::vector<std::vector<std::uint32_t>> deal_triangles(const WholeMesh& share, const ShareLinks& links) {
  std::vector<std::vector<std::uint32_t>> dealt(links.part_tets.size() - 1);
  const auto part_of = [&](std::uint32_t tet) {
    return static_cast<std::size_t>(std::ranges::upper_bound(links.part_tets, std::size_t{tet}) -
                                    links.part_tets.begin()) -
           1;
  };
  for (std::uint32_t i = 0; i < share.triangles.size(); ++i) dealt[part_of(share.triangles[i].tets[0])].push_back(i);
  return dealt;
}

}  // namespace

std::vector<std::array<std::uint32_t, 4>> tets_of(const PartMesh& part) {
  const auto& to_vert = part.block(CellKind::Tet).to_vert;
  std::vector<std::array<std::uint32_t, 4>> tets(to_vert.size() / 4);
  for (std::size_t tet = 0; tet < tets.size(); ++tet) std::copy_n(&to_vert[tet * 4], 4, tets[tet].begin());
  return tets;
}

PartsWithMetric make_parts(const SharePieces& pieces, std::size_t part_count, const SharedWork& work) {
  const JoinedNumbers numbers(pieces, work);
  const TableSizes tables(pieces, numbers, work);
  PartsWithMetric made{PartitionedMesh(work.ranks(), part_count), {}};
  made.to_metric = PerPart<GrowingArray<VertexMetric>>(part_count, made.mesh.local());
  made.mesh.vertex_fields = pieces.on_points.infos, made.mesh.cell_fields = pieces.on_tets.infos;
  work.each([&] {
    const auto triangles = deal_triangles(pieces.share, pieces.links);
    work.runner().for_each(triangles.size(), [&](std::size_t i) {
      const PartId part = made.mesh.local()[i];
      made.mesh.parts.at(part).mesh = PartMaker(pieces, numbers, tables, i).run(triangles[i], made.to_metric.at(part));
    });
    pieces.share = WholeMesh();
  });
  link_parts(made.mesh, work.runner());
  return made;
}

}  // namespace tetloom::adapt
