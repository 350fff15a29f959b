#include "adapt/parts/join_parts.hpp"

#include <algorithm>
#include <numeric>

#include "tetloom/tasks.hpp"
#include "threading/runtime/parallel_sort.hpp"

namespace tetloom::adapt {

namespace {

// A face between two parts, by its vertices.
struct OpenFace {
  Triangle verts{};  // ascending
  std::uint32_t triangle = kNone;
  FaceCode face;
  friend bool operator<(const OpenFace& a, const OpenFace& b) {
    return a.verts != b.verts ? a.verts < b.verts : a.face < b.face;
  }
};

// A face that other ranks may have, by the numbers of its vertices.
struct FaceBetweenRanks {
  std::array<Number, 3> verts{};  // ascending
  RemoteFace face;
  friend auto operator<=>(const FaceBetweenRanks&, const FaceBetweenRanks&) = default;
};

// The number that a vertex had before the round, and the one that it has now.
struct Renumbered {
  Number old_number, number;
};

class PartsJoiner {
 public:
  PartsJoiner(const RoundShare& old, std::vector<PartOfWhole>& parts, ShareLinks& links, const SharedWork& work)
      : old_(old), parts_(parts), links_(links), work_(work), runner_(work.runner()) {}

  WholeMesh run() {
    work_.each([&] { number(); });
    number_shares();
    number_foreign();
    WholeMesh whole;
    work_.each([&] {
      write_parts(whole);
      link(whole);
    });
    link_outside();
    return whole;
  }

 private:
  std::size_t rank() const { return static_cast<std::size_t>(work_.rank()); }

  // Whether a vertex of the old share is numbered by a lower rank.
  bool is_foreign(std::uint32_t old) const { return !is_foreign_.empty() && is_foreign_[old] != 0; }

  // Vertices that parts share belong to the first part that has them.
  void number() {
    find_foreign();
    old_to_new_.resize(old_.vert_count, kNone), to_first_part_.resize(old_.vert_count, kNone);
    for (std::uint32_t p = 0; p < parts_.size(); ++p) {
      const PartOfWhole& part = parts_[p];
      first_tet_.push_back(tet_count_), first_vert_.push_back(vert_count_);
      tet_count_ += part.mesh.mesh.size();
      auto& to_new = to_new_.emplace_back();
      to_new.resize(part.mesh.mesh.points.size(), kNone);
      for (std::uint32_t v = 0; v < to_new.size(); ++v) {
        if (part.mesh.to_frozen[v] == 0) {
          to_new[v] = vert_count_++;
          continue;
        }
        const std::uint32_t old = part.to_whole[v];
        if (to_first_part_[old] == kNone) to_first_part_[old] = p;
        if (is_foreign(old)) continue;
        if (old_to_new_[old] == kNone) old_to_new_[old] = vert_count_++;
        to_new[v] = old_to_new_[old];
      }
    }
  }

  void find_foreign() {
    if (work_.rank_count() == 1) return;
    is_foreign_.assign(old_.vert_count, 0);
    const Residence& outside = old_.outside;
    for (std::size_t i = 0; i < outside.verts.size(); ++i)
      is_foreign_[outside.verts[i]] = outside.parts[outside.first[i]].value < rank();
  }

  // Where the numbers of each rank begin.
  void number_shares() {
    const std::array<std::uint64_t, 2> counts{tet_count_, vert_count_};
    links_.first_tets.assign(1, first_number()), links_.first_verts.assign(1, first_number());
    links_.part_tets = first_tet_, links_.part_verts = first_vert_;
    links_.part_tets.push_back(tet_count_), links_.part_verts.push_back(vert_count_);
    for (const Bytes& bytes : work_.all_gather([&](MessageWriter& writer) { writer.put(counts); })) {
      const auto given = MessageReader(bytes).get<std::array<std::uint64_t, 2>>();
      if (given[0] >= CellPlace::kMaxTets) throw std::bad_alloc();
      links_.first_tets.push_back(links_.first_tets.back() + given[0]);
      links_.first_verts.push_back(links_.first_verts.back() + given[1]);
    }
  }

  // Those that lower ranks have numbered come after this rank's own, ascending.
  void number_foreign() {
    links_.to_number.clear();
    if (work_.rank_count() == 1) return;
    const std::vector<Bytes> given = work_.exchange([&](std::span<MessageWriter> to) { put_numbers(to); });
    work_.each([&] {
      std::vector<Renumbered> foreign;
      for (const Bytes& bytes : given) {
        const auto numbers = MessageReader(bytes).get_view<Renumbered>();
        foreign.insert(foreign.end(), numbers.begin(), numbers.end());
      }
      std::ranges::sort(foreign, {}, &Renumbered::number);
      links_.to_number.resize(vert_count_);
      std::iota(links_.to_number.begin(), links_.to_number.end(), links_.first_verts[rank()]);
      for (const Renumbered& vert : foreign) {
        const auto old = std::ranges::lower_bound(old_.to_number, vert.old_number) - old_.to_number.begin();
        old_to_new_[static_cast<std::size_t>(old)] = static_cast<std::uint32_t>(links_.to_number.size());
        links_.to_number.push_back(vert.number);
      }
      for (std::size_t p = 0; p < parts_.size(); ++p)
        for (std::uint32_t v = 0; v < to_new_[p].size(); ++v)
          if (to_new_[p][v] == kNone) to_new_[p][v] = old_to_new_[parts_[p].to_whole[v]];
    });
  }

  void put_numbers(std::span<MessageWriter> to) const {
    std::vector<std::vector<Renumbered>> numbers(to.size());
    const Residence& outside = old_.outside;
    for (std::size_t i = 0; i < outside.verts.size(); ++i) {
      const std::uint32_t old = outside.verts[i];
      if (is_foreign(old)) continue;
      for (std::uint32_t k = outside.first[i]; k < outside.first[i + 1]; ++k)
        numbers[outside.parts[k].value].push_back({old_.to_number[old], links_.first_verts[rank()] + old_to_new_[old]});
    }
    for (std::size_t r = 0; r < to.size(); ++r) to[r].put_array(std::span<const Renumbered>(numbers[r]));
  }

  void write_parts(WholeMesh& whole) {
    const std::size_t verts = std::max<std::size_t>(vert_count_, links_.to_number.size());
    whole.points.resize_for_overwrite(verts), whole.to_metric.resize_for_overwrite(verts);
    whole.to_entity.resize_for_overwrite(verts), whole.to_hint.resize_for_overwrite(verts);
    whole.to_state.resize_for_overwrite(verts);
    whole.to_vert.resize_for_overwrite(tet_count_ * 4), whole.to_neighbor.resize_for_overwrite(tet_count_ * 4);
    whole.to_region.resize_for_overwrite(tet_count_);
    triangles_.resize(parts_.size()), edges_.resize(parts_.size()), open_.resize(parts_.size());
    runner_.for_each(parts_.size(), [&](std::size_t p) {
      write_verts(p, whole);
      write_tets(p, whole);
      parts_[p] = PartOfWhole();
    });
    for (std::size_t p = 0; p < parts_.size(); ++p) {
      first_triangle_.push_back(whole.triangles.size());
      whole.triangles.insert(whole.triangles.end(), triangles_[p].begin(), triangles_[p].end());
      whole.edges.insert(whole.edges.end(), edges_[p].begin(), edges_[p].end());
    }
    sort_pieces(whole.edges);
  }

  // Of each vertex the first part that has it writes what there is of it.
  void write_verts(std::size_t p, WholeMesh& whole) const {
    const CavityMesh& mesh = parts_[p].mesh;
    for (std::uint32_t v = 0; v < to_new_[p].size(); ++v) {
      if (mesh.to_frozen[v] != 0 && to_first_part_[parts_[p].to_whole[v]] != p) continue;
      const std::uint32_t to = to_new_[p][v];
      whole.points[to] = mesh.point(v), whole.to_metric[to] = mesh.to_metric[v];
      whole.to_entity[to] = mesh.to_entity[v], whole.to_hint[to] = mesh.to_hint[v];
      // What could not be changed at the sides of parts is asked again.
      const std::uint8_t state = mesh.to_state[v];
      whole.to_state[to] =
          mesh.to_frozen[v] != 0
              ? std::uint8_t{kHasChanged | kUnsettled}
              : static_cast<std::uint8_t>((state & kUnsettled) | ((state & kChanged) != 0 ? kHasChanged : 0));
    }
  }

  void write_tets(std::size_t p, WholeMesh& whole) {
    const CavityMesh& mesh = parts_[p].mesh;
    const auto& to_new = to_new_[p];
    const auto base = static_cast<std::uint32_t>(first_tet_[p]);
    for (std::uint32_t tet = 0; tet < mesh.mesh.size(); ++tet) {
      whole.to_region[base + tet] = mesh.mesh.to_region[tet];
      for (std::uint32_t i = 0; i < 4; ++i) {
        const FaceCode face(tet, i), behind = mesh.mesh.behind(face);
        const FaceCode to(base + tet, i);
        whole.to_vert[to.index()] = to_new[mesh.mesh.apex(face)];
        whole.behind(to) = behind.valid() ? behind.of_tet(base + behind.tet()) : FaceCode();
        if (mesh.mesh.is_fixed(face) && (!behind.valid() || face < behind)) write_face(p, face);
      }
    }
    mesh.surface.for_each_edge([&](std::uint32_t a, std::uint32_t b, std::uint32_t edge) {
      edges_[p].push_back({{std::min(to_new[a], to_new[b]), std::max(to_new[a], to_new[b])}, edge});
    });
  }

  // A triangle of the surface, a face that another part may have, or both.
  void write_face(std::size_t p, FaceCode face) {
    const CavityMesh& mesh = parts_[p].mesh;
    const auto base = static_cast<std::uint32_t>(first_tet_[p]);
    const FaceCode behind = mesh.mesh.behind(face);
    Triangle verts = tets::verts_of(mesh.mesh, face);
    const SurfaceTriangle* found = mesh.surface.find(verts);
    const bool frozen = mesh.to_frozen[verts[0]] && mesh.to_frozen[verts[1]] && mesh.to_frozen[verts[2]];
    OpenFace open;
    if (found) {
      LinkedTriangle triangle{*found, {base + face.tet(), !behind.valid() ? kNone : base + behind.tet()}};
      for (std::uint32_t& v : triangle.triangle.verts) v = to_new_[p][v];
      open.triangle = static_cast<std::uint32_t>(triangles_[p].size());
      triangles_[p].push_back(triangle);
    }
    if (behind.valid() || !frozen) return;
    for (std::uint32_t& v : verts) v = to_new_[p][v];
    std::ranges::sort(verts);
    open.verts = verts, open.face = face.of_tet(base + face.tet());
    open_[p].push_back(open);
  }

  // Faces that two parts of this rank have; of a triangle there, the second copy goes.
  void link(WholeMesh& whole) {
    const GrowingArray<OpenFace> all = by_lowest_vertex(whole.points.size());
    std::vector<std::uint32_t> twice;
    for (std::size_t begin = 0, end = 0; begin < all.size(); begin = end) {
      while (end < all.size() && all[end].verts[0] == all[begin].verts[0]) ++end;
      for (std::size_t i = begin; i < end; ++i) {
        const OpenFace& a = all[i];
        if (whole.behind(a.face).valid()) continue;
        const OpenFace* b =
            std::find_if(&all[i] + 1, all.begin() + end, [&](const OpenFace& face) { return face.verts == a.verts; });
        if (b == all.begin() + end) {
          alone_.push_back(a);
          continue;
        }
        whole.behind(a.face) = b->face, whole.behind(b->face) = a.face;
        if (a.triangle == kNone) continue;
        whole.triangles[a.triangle].tets[1] = b->face.tet();
        twice.push_back(b->triangle);
      }
    }
    std::ranges::sort(twice);
    std::size_t kept = 0, next = 0;
    for (std::size_t i = 0; i < whole.triangles.size(); ++i) {
      if (next < twice.size() && twice[next] == i) {
        ++next;
        continue;
      }
      whole.triangles[kept++] = whole.triangles[i];
    }
    whole.triangles.resize(kept);
  }

  // The open faces of all parts; those with the same lowest vertex in the order of parts.
  GrowingArray<OpenFace> by_lowest_vertex(std::size_t vert_count) {
    GrowingArray<std::uint32_t> ends;
    ends.resize(vert_count + 1, 0);
    for (const auto& faces : open_)
      for (const OpenFace& face : faces) ++ends[face.verts[0] + 1];
    for (std::size_t v = 0; v < vert_count; ++v) ends[v + 1] += ends[v];
    GrowingArray<OpenFace> all;
    all.resize_for_overwrite(ends.back());
    for (std::size_t p = 0; p < open_.size(); ++p) {
      for (OpenFace& face : open_[p]) {
        if (face.triangle != kNone) face.triangle += static_cast<std::uint32_t>(first_triangle_[p]);
        all[ends[face.verts[0]]++] = face;
      }
      open_[p].release();
    }
    return all;
  }

  // Faces that other ranks may have meet at the rank that has numbered their lowest vertex.
  void link_outside() {
    links_.faces.clear();
    if (work_.rank_count() == 1) return;
    const std::vector<Bytes> told = work_.exchange([&](std::span<MessageWriter> to) { put_faces(to); });
    const std::vector<Bytes> found = work_.exchange([&](std::span<MessageWriter> to) { match_faces(told, to); });
    work_.each([&] {
      links_.faces = joined_lists<FaceOutside>(found);
      std::ranges::sort(links_.faces);
    });
  }

  void put_faces(std::span<MessageWriter> to) const {
    std::vector<std::uint8_t> is_outside(links_.to_number.size(), 0);
    for (const std::uint32_t old : old_.outside.verts) is_outside[old_to_new_[old]] = 1;
    std::vector<std::vector<FaceBetweenRanks>> faces(to.size());
    for (const OpenFace& open : alone_) {
      if (!is_outside[open.verts[0]] || !is_outside[open.verts[1]] || !is_outside[open.verts[2]]) continue;
      FaceBetweenRanks face{{}, {static_cast<std::uint32_t>(rank()), open.face}};
      std::ranges::transform(open.verts, face.verts.begin(), [&](std::uint32_t v) { return links_.to_number[v]; });
      std::ranges::sort(face.verts);
      faces[rank_in(links_.first_verts, face.verts[0])].push_back(face);
    }
    for (std::size_t r = 0; r < to.size(); ++r) to[r].put_array(std::span<const FaceBetweenRanks>(faces[r]));
  }

  void match_faces(const std::vector<Bytes>& told, std::span<MessageWriter> to) const {
    std::vector<FaceBetweenRanks> all = joined_lists<FaceBetweenRanks>(told);
    parallel_sort(all, runner_);
    std::vector<std::vector<FaceOutside>> pairs(to.size());
    for (std::size_t i = 0; i + 1 < all.size(); ++i) {
      const FaceBetweenRanks &a = all[i], &b = all[i + 1];
      if (a.verts != b.verts) continue;
      pairs[a.face.rank].push_back({a.face.face, b.face});
      pairs[b.face.rank].push_back({b.face.face, a.face});
      ++i;
    }
    for (std::size_t r = 0; r < to.size(); ++r) to[r].put_array(std::span<const FaceOutside>(pairs[r]));
  }

  const RoundShare& old_;
  std::vector<PartOfWhole>& parts_;
  ShareLinks& links_;
  const SharedWork& work_;
  const TaskRunner& runner_;
  std::vector<std::uint8_t> is_foreign_;
  GrowingArray<std::uint32_t> old_to_new_, to_first_part_;  // of shared vertices
  std::vector<GrowingArray<std::uint32_t>> to_new_;         // of the vertices of each part
  std::vector<std::size_t> first_tet_, first_vert_, first_triangle_;
  std::vector<std::vector<LinkedTriangle>> triangles_;
  std::vector<std::vector<ModelEdgePiece>> edges_;
  std::vector<GrowingArray<OpenFace>> open_;
  std::vector<OpenFace> alone_;  // those with nothing behind them on this rank
  std::uint32_t vert_count_ = 0;
  std::size_t tet_count_ = 0;
};

}  // namespace

WholeMesh join_parts(const RoundShare& old, std::vector<PartOfWhole>& parts, ShareLinks& links,
                     const SharedWork& work) {
  return PartsJoiner(old, parts, links, work).run();
}

}  // namespace tetloom::adapt
