#include "adapt/parts/share.hpp"

#include <algorithm>
#include <new>

#include "core/base/lists.hpp"

namespace tetloom::adapt {

namespace {

// Cuts a rank's tets out of a mesh that has others, too.
class ShareTaker {
 public:
  /// Numbers of the vertices and tets that are there; none: as they stand, for what no rank shares.
  ShareTaker(const WholeMesh& whole, std::size_t begin, std::size_t end, std::span<const Number> verts = {},
             std::span<const Number> tets = {})
      : whole_(whole), begin_(begin), end_(end), verts_(verts), tets_(tets), to_local_(whole.points.size(), kNone) {}

  /// Linked where there is a list of `faces`, to which those with tets of other ranks behind them are added.
  WholeMesh run(ShareLinks& links, std::vector<FaceOutside>* faces = nullptr) {
    take_verts(links.to_number);
    find_shared(links.shared);
    take_tets();
    if (faces != nullptr) take_links(links.first_tets, *faces);
    take_triangles();
    take_edges();
    return std::move(share_);
  }

 private:
  bool has(std::uint32_t tet) const { return tet >= begin_ && tet < end_; }
  std::uint32_t local_tet(std::uint32_t tet) const {
    return has(tet) ? tet - static_cast<std::uint32_t>(begin_) : kNone;
  }

  RemoteFace remote(FaceCode face, const std::vector<Number>& first_tets) const {
    const Number number = tets_[face.tet()];
    const std::size_t rank = rank_in(first_tets, number);
    return {static_cast<std::uint32_t>(rank), face.of_tet(static_cast<std::uint32_t>(number - first_tets[rank]))};
  }

  void take_verts(std::vector<Number>& to_number) {
    for (std::size_t i = begin_ * 4; i < end_ * 4; ++i) to_local_[whole_.to_vert[i]] = 0;
    for (std::uint32_t v = 0; v < to_local_.size(); ++v) {
      if (to_local_[v] == kNone) continue;
      to_local_[v] = static_cast<std::uint32_t>(to_number.size());
      to_number.push_back(verts_.empty() ? first_number() + v : verts_[v]);
      share_.points.push_back(whole_.points[v]);
      share_.to_metric.push_back(whole_.to_metric.empty() ? VertexMetric() : whole_.to_metric[v]);
      share_.to_entity.push_back(whole_.to_entity[v]);
      share_.to_hint.push_back(whole_.to_hint[v]);
      share_.to_state.push_back(whole_.to_state[v]);
    }
  }

  void find_shared(std::vector<std::uint32_t>& shared) const {
    const auto find_in = [&](std::span<const std::uint32_t> others) {
      for (const std::uint32_t v : others)
        if (to_local_[v] != kNone) shared.push_back(to_local_[v]);
    };
    find_in(whole_.to_vert.span().first(begin_ * 4)), find_in(whole_.to_vert.span().subspan(end_ * 4));
    sort_unique(shared);
  }

  void take_tets() {
    for (std::size_t i = begin_ * 4; i < end_ * 4; ++i) share_.to_vert.push_back(to_local_[whole_.to_vert[i]]);
    share_.to_region.append(whole_.to_region.span().subspan(begin_, end_ - begin_));
  }

  void take_links(const std::vector<Number>& first_tets, std::vector<FaceOutside>& faces) {
    for (std::size_t i = begin_ * 4; i < end_ * 4; ++i) {
      const FaceCode behind = whole_.to_neighbor[i];
      const std::uint32_t behind_here = behind.valid() ? local_tet(behind.tet()) : kNone;
      if (behind.valid() && behind_here == kNone)
        faces.push_back({FaceCode::at(i - begin_ * 4), remote(behind, first_tets)});
      share_.to_neighbor.push_back(behind_here == kNone ? FaceCode() : behind.of_tet(behind_here));
    }
  }

  void take_triangles() {
    for (LinkedTriangle t : whole_.triangles) {
      for (std::uint32_t& tet : t.tets) tet = tet == kNone ? kNone : local_tet(tet);
      if (t.tets[0] == kNone) std::swap(t.tets[0], t.tets[1]);
      if (t.tets[0] == kNone) continue;
      for (std::uint32_t& v : t.triangle.verts) v = to_local_[v];
      share_.triangles.push_back(t);
    }
  }

  void take_edges() {
    for (std::size_t tet = begin_; tet < end_; ++tet)
      for_each_piece(whole_, static_cast<std::uint32_t>(tet), [&](ModelEdgePiece piece) {
        for (std::uint32_t& v : piece.verts) v = to_local_[v];
        share_.edges.push_back(piece);
      });
    sort_pieces(share_.edges);
  }

  const WholeMesh& whole_;
  std::size_t begin_, end_;
  std::span<const Number> verts_, tets_;
  std::vector<std::uint32_t> to_local_;
  WholeMesh share_;
};

bool uses_all_points(const WholeMesh& whole) {
  std::vector<std::uint8_t> used(whole.points.size(), 0);
  for (const std::uint32_t v : whole.to_vert) used[v] = 1;
  return std::ranges::count(used, 0) == 0;
}

constexpr std::size_t kLengths = 256;  // bytes for those of all arrays of a message

// What a rank has that no lower one has, all of it by places in the whole mesh.
void put_share(const WholeMesh& share, const ShareLinks& links, int rank, MessageWriter& writer) {
  const std::size_t own = own_vert_count(links, rank);
  const auto place_of = [&](std::uint32_t v) {
    return static_cast<std::uint32_t>(links.number_of(v) - links.first_verts.front());
  };
  constexpr std::size_t kBytesOfVert = sizeof(Vec3) + sizeof(VertexMetric) + sizeof(PackedEntity);
  writer.reserve(kLengths + own * kBytesOfVert + share.size() * 5 * sizeof(std::uint32_t) +
                 share.triangles.size() * sizeof(SurfaceTriangle) + share.edges.size() * sizeof(ModelEdgePiece));
  writer.put_array(share.points.span().first(own));
  writer.put_array(share.to_metric.span().first(own));
  writer.put_array(share.to_entity.span().first(own));
  writer.put_each(share.to_vert, place_of);
  writer.put_array(share.to_region.span());
  writer.put_each(share.triangles, [&](const LinkedTriangle& t) {
    SurfaceTriangle triangle = t.triangle;
    for (std::uint32_t& v : triangle.verts) v = place_of(v);
    return triangle;
  });
  std::vector<ModelEdgePiece> edges = share.edges;
  for (ModelEdgePiece& piece : edges) {
    for (std::uint32_t& v : piece.verts) v = place_of(v);
    std::ranges::sort(piece.verts);
  }
  writer.put_array(std::span<const ModelEdgePiece>(edges));
}

void take_all(std::vector<Bytes>& given, WholeMesh& whole) {
  for (Bytes& bytes : given) {
    MessageReader reader(bytes);
    whole.points.append(reader.get_view<Vec3>());
    whole.to_metric.append(reader.get_view<VertexMetric>());
    whole.to_entity.append(reader.get_view<PackedEntity>());
    whole.to_vert.append(reader.get_view<std::uint32_t>());
    whole.to_region.append(reader.get_view<std::uint32_t>());
    for (const SurfaceTriangle& triangle : reader.get_view<SurfaceTriangle>())
      whole.triangles.push_back({triangle, {}});
    const auto edges = reader.get_view<ModelEdgePiece>();
    whole.edges.insert(whole.edges.end(), edges.begin(), edges.end());
    bytes = Bytes();
  }
  sort_pieces(whole.edges);
}

}  // namespace

ShareLinks take_share(WholeMesh& whole) {
  ShareLinks links;
  links.first_tets = equal_ranges(whole.size(), 1);
  if (!uses_all_points(whole)) {
    whole = ShareTaker(whole, 0, whole.size()).run(links);
    links.to_number.clear();
  }
  links.first_verts = equal_ranges(whole.points.size(), 1);
  return links;
}

ShareLinks take_share(WholeMesh& slice_mesh, const MeshSlice& slice, std::vector<FaceOutside>& faces) {
  ShareLinks links;
  links.first_tets = slice.first_tets;
  links.first_verts = equal_ranges(slice.vert_count, slice.first_tets.size() - 1);
  slice_mesh =
      ShareTaker(slice_mesh, slice.begin, slice.end, slice.to_vert_number, slice.to_tet_number).run(links, &faces);
  return links;
}

WholeMesh gather_shares(WholeMesh& share, const ShareLinks& links, const SharedWork& work) {
  if (work.rank_count() == 1) return std::move(share);
  if (links.tet_count() >= CellPlace::kMaxTets) throw std::bad_alloc();
  std::vector<Bytes> given = work.exchange([&](std::span<MessageWriter> to) {
    put_share(share, links, work.rank(), to[0]);
    share = WholeMesh();
  });
  WholeMesh whole;
  work.each([&] {
    if (work.rank() == 0) take_all(given, whole);
  });
  return whole;
}

}  // namespace tetloom::adapt
