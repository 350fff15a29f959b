#include "adapt/parts/join_parts.hpp"

#include <algorithm>
#include <numeric>

#include "tetloom/tasks.hpp"

namespace tetloom::adapt {

namespace {

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
      find_shared();
    });
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
    whole.to_vert.resize_for_overwrite(tet_count_ * 4);
    whole.to_region.resize_for_overwrite(tet_count_);
    triangles_.resize(parts_.size()), edges_.resize(parts_.size());
    runner_.for_each(parts_.size(), [&](std::size_t p) {
      write_verts(p, whole);
      write_tets(p, whole);
      parts_[p] = PartOfWhole();
    });
    for (std::size_t p = 0; p < parts_.size(); ++p) {
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
        whole.to_vert[FaceCode(base + tet, i).index()] = to_new[mesh.mesh.apex(face)];
        if (mesh.mesh.is_fixed(face) && (!behind.valid() || face < behind)) write_triangle(p, face);
      }
    }
    mesh.surface.for_each_edge([&](std::uint32_t a, std::uint32_t b, std::uint32_t edge) {
      edges_[p].push_back({{std::min(to_new[a], to_new[b]), std::max(to_new[a], to_new[b])}, edge});
    });
  }

  // Where the face is one of the surface.
  void write_triangle(std::size_t p, FaceCode face) {
    const CavityMesh& mesh = parts_[p].mesh;
    const SurfaceTriangle* found = mesh.surface.find(tets::verts_of(mesh.mesh, face));
    if (found == nullptr) return;
    const auto base = static_cast<std::uint32_t>(first_tet_[p]);
    const FaceCode behind = mesh.mesh.behind(face);
    LinkedTriangle& triangle = triangles_[p].emplace_back(
        LinkedTriangle{*found, {base + face.tet(), !behind.valid() ? kNone : base + behind.tet()}});
    for (std::uint32_t& v : triangle.triangle.verts) v = to_new_[p][v];
  }

  void find_shared() {
    links_.shared.clear();
    for (const std::uint32_t old : old_.outside.verts) links_.shared.push_back(old_to_new_[old]);
    std::ranges::sort(links_.shared);
  }

  const RoundShare& old_;
  std::vector<PartOfWhole>& parts_;
  ShareLinks& links_;
  const SharedWork& work_;
  const TaskRunner& runner_;
  std::vector<std::uint8_t> is_foreign_;
  GrowingArray<std::uint32_t> old_to_new_, to_first_part_;  // of shared vertices
  std::vector<GrowingArray<std::uint32_t>> to_new_;         // of the vertices of each part
  std::vector<std::size_t> first_tet_, first_vert_;
  std::vector<std::vector<LinkedTriangle>> triangles_;
  std::vector<std::vector<ModelEdgePiece>> edges_;
  std::uint32_t vert_count_ = 0;
  std::size_t tet_count_ = 0;
};

}  // namespace

WholeMesh join_parts(const RoundShare& old, std::vector<PartOfWhole>& parts, ShareLinks& links,
                     const SharedWork& work) {
  return PartsJoiner(old, parts, links, work).run();
}

}  // namespace tetloom::adapt
