#include <algorithm>
#include <unordered_map>

#include "adapt/parts/whole_mesh.hpp"
#include "threading/parallel_sort.hpp"

namespace tetloom::adapt {

namespace {

using tets::kFaceVerts;

constexpr std::uint32_t kShared = kNone - 1;
constexpr std::size_t kGrain = std::size_t{1} << 14;

// A face between two parts, by its vertices in the whole mesh to be.
struct OpenFace {
  Triangle verts;  // ascending
  std::uint32_t triangle = kNone;
  FaceCode face = kNone;
  friend bool operator<(const OpenFace& a, const OpenFace& b) {
    return a.verts != b.verts ? a.verts < b.verts : a.face < b.face;
  }
};

class Cutter {
 public:
  Cutter(const WholeMesh& whole, std::span<const std::uint32_t> to_part, std::size_t part_count,
         const TaskRunner& runner)
      : whole_(whole), to_part_(to_part), runner_(runner), parts_(part_count) {}

  // Which part has a vertex, or that several do; which tets and triangles a part has.
  void sort() {
    owner_.assign(whole_.points.size(), kNone);
    part_to_tets_.resize(parts_);
    part_to_triangles_.resize(parts_);
    local_tet_.resize(whole_.size());
    local_vert_.resize(whole_.points.size());
    for (std::uint32_t tet = 0; tet < whole_.size(); ++tet) {
      const std::uint32_t part = to_part_[tet];
      local_tet_[tet] = static_cast<std::uint32_t>(part_to_tets_[part].size());
      part_to_tets_[part].push_back(tet);
      for (std::size_t i = 0; i < 4; ++i) {
        std::uint32_t& owner = owner_[whole_.to_vert[std::size_t{tet} * 4 + i]];
        owner = owner == kNone || owner == part ? part : kShared;
      }
    }
    for (std::uint32_t i = 0; i < whole_.triangles.size(); ++i) {
      const auto& tets = whole_.triangles[i].tets;
      part_to_triangles_[to_part_[tets[0]]].push_back(i);
      if (tets[1] != kNone && to_part_[tets[1]] != to_part_[tets[0]])
        part_to_triangles_[to_part_[tets[1]]].push_back(i);
    }
  }

  bool is_shared(std::uint32_t vert) const { return owner_[vert] == kShared; }

  void build(std::uint32_t number, PartOfWhole& part) {
    CavityMesh& mesh = part.mesh;
    std::unordered_map<std::uint32_t, std::uint32_t> shared;
    const auto& tets = part_to_tets_[number];
    const auto local_of = [&](std::uint32_t v) {
      if (owner_[v] == kShared) {
        const auto [at, is_new] = shared.emplace(v, static_cast<std::uint32_t>(part.to_whole.size()));
        if (is_new) part.to_whole.push_back(v);
        return at->second;
      }
      std::uint32_t& local = local_vert_[v];
      if (local >= part.to_whole.size() || part.to_whole[local] != v) {
        local = static_cast<std::uint32_t>(part.to_whole.size());
        part.to_whole.push_back(v);
      }
      return local;
    };
    TetMesh& m = mesh.mesh;
    m.to_vert.reserve(tets.size() * 5), m.to_neighbor.reserve(tets.size() * 5);
    for (const std::uint32_t tet : tets) {
      std::uint8_t fixed = 0;
      for (std::uint32_t i = 0; i < 4; ++i) {
        m.to_vert.push_back(local_of(whole_.to_vert[std::size_t{tet} * 4 + i]));
        const FaceCode behind = whole_.to_neighbor[std::size_t{tet} * 4 + i];
        const bool open = behind == kNone || to_part_[behind / 4] != number;
        m.to_neighbor.push_back(open ? kNone : local_tet_[behind / 4] * 4 + behind % 4);
        fixed |= static_cast<std::uint8_t>(unsigned{open} << i);
      }
      m.to_fixed.push_back(fixed);
      m.to_region.push_back(whole_.to_region[tet]);
    }
    for (const std::uint32_t v : part.to_whole) {
      m.points.push_back(whole_.points[v]);
      mesh.to_metric.push_back(whole_.to_metric[v]);
      mesh.to_entity.push_back(whole_.to_entity[v]);
      mesh.to_hint.push_back(whole_.to_hint[v]);
      mesh.to_frozen.push_back(static_cast<std::uint8_t>(owner_[v] == kShared));
      mesh.to_state.push_back(whole_.to_state[v]);
    }
    part.given = static_cast<std::uint32_t>(part.to_whole.size());
    const auto find_local = [&](std::uint32_t v) {
      if (owner_[v] == number) return local_vert_[v];
      const auto at = shared.find(v);
      return at == shared.end() ? kNone : at->second;
    };
    for (const std::uint32_t i : part_to_triangles_[number]) {
      SurfaceTriangle triangle = whole_.triangles[i].triangle;
      for (std::uint32_t& v : triangle.verts) v = find_local(v);
      mesh.surface.add(triangle);
      for (const std::uint32_t tet : whole_.triangles[i].tets) {
        if (tet == kNone || to_part_[tet] != number) continue;
        const std::uint32_t local = local_tet_[tet];
        for (std::uint32_t f = 0; f < 4; ++f) {
          const std::uint32_t apex = mesh.verts(local)[f];
          if (std::find(triangle.verts.begin(), triangle.verts.end(), apex) == triangle.verts.end())
            m.to_fixed[local] |= static_cast<std::uint8_t>(1u << f);
        }
      }
    }
    for (const ModelEdgePiece& piece : whole_.edges) {
      const std::uint32_t a = find_local(piece.verts[0]);
      if (a == kNone) continue;
      const std::uint32_t b = find_local(piece.verts[1]);
      if (b != kNone) mesh.surface.add_edge(a, b, piece.edge);
    }
    mesh.start();
  }

 private:
  const WholeMesh& whole_;
  std::span<const std::uint32_t> to_part_;
  const TaskRunner& runner_;
  std::size_t parts_;
  std::vector<std::uint32_t> owner_, local_tet_, local_vert_;
  std::vector<std::vector<std::uint32_t>> part_to_tets_, part_to_triangles_;
};

class Joiner {
 public:
  Joiner(const WholeMesh& old, std::vector<PartOfWhole>& parts, const Cutter& cutter, const TaskRunner& runner)
      : old_(old), parts_(parts), cutter_(cutter), runner_(runner) {}

  WholeMesh run() {
    number();
    WholeMesh whole;
    whole.points.resize_for_overwrite(vert_count_), whole.to_metric.resize_for_overwrite(vert_count_);
    whole.to_entity.resize_for_overwrite(vert_count_), whole.to_hint.resize_for_overwrite(vert_count_);
    whole.to_state.resize_for_overwrite(vert_count_);
    whole.to_vert.resize_for_overwrite(tet_count_ * 4), whole.to_neighbor.resize_for_overwrite(tet_count_ * 4);
    whole.to_region.resize_for_overwrite(tet_count_);
    triangles_.resize(parts_.size()), edges_.resize(parts_.size()), open_.resize(parts_.size());
    runner_.for_each(parts_.size(), [&](std::size_t p) { write(p, whole); });
    for (std::size_t p = 0; p < parts_.size(); ++p) {
      first_triangle_.push_back(whole.triangles.size());
      whole.triangles.insert(whole.triangles.end(), triangles_[p].begin(), triangles_[p].end());
      whole.edges.insert(whole.edges.end(), edges_[p].begin(), edges_[p].end());
    }
    std::sort(whole.edges.begin(), whole.edges.end());
    whole.edges.erase(std::unique(whole.edges.begin(), whole.edges.end()), whole.edges.end());
    link(whole);
    return whole;
  }

 private:
  // Vertices that parts share belong to the first part that has them.
  void number() {
    shared_to_new_.assign(old_.points.size(), kNone);
    for (PartOfWhole& part : parts_) {
      first_vert_.push_back(vert_count_), first_tet_.push_back(tet_count_);
      tet_count_ += part.mesh.mesh.size();
      auto& to_new = to_new_.emplace_back(part.mesh.mesh.points.size(), kNone);
      for (std::uint32_t v = 0; v < to_new.size(); ++v) {
        const std::uint32_t old = part.to_whole[v];
        if (old != kNone && cutter_.is_shared(old)) {
          if (shared_to_new_[old] == kNone) shared_to_new_[old] = vert_count_++;
          to_new[v] = shared_to_new_[old];
        } else {
          to_new[v] = vert_count_++;
        }
      }
    }
    if (tet_count_ > CellPlace::kMaxTets) throw std::bad_alloc();
  }

  void write(std::size_t p, WholeMesh& whole) {
    PartOfWhole& part = parts_[p];
    const CavityMesh& mesh = part.mesh;
    const auto& to_new = to_new_[p];
    const auto base = static_cast<std::uint32_t>(first_tet_[p]);
    for (std::uint32_t v = 0; v < to_new.size(); ++v) {
      if (to_new[v] < first_vert_[p]) continue;
      whole.points[to_new[v]] = mesh.point(v), whole.to_metric[to_new[v]] = mesh.to_metric[v];
      whole.to_entity[to_new[v]] = mesh.to_entity[v], whole.to_hint[to_new[v]] = mesh.to_hint[v];
      // What could not be changed at the sides of parts is asked again.
      const std::uint8_t state = mesh.to_state[v];
      whole.to_state[to_new[v]] =
          mesh.to_frozen[v] != 0
              ? std::uint8_t{kHasChanged | kUnsettled}
              : static_cast<std::uint8_t>((state & kUnsettled) | ((state & kChanged) != 0 ? kHasChanged : 0));
    }
    for (std::uint32_t tet = 0; tet < mesh.mesh.size(); ++tet) {
      whole.to_region[base + tet] = mesh.mesh.to_region[tet];
      for (std::uint32_t i = 0; i < 4; ++i) {
        const FaceCode face = tet * 4 + i, behind = mesh.mesh.to_neighbor[face];
        whole.to_vert[std::size_t{base} * 4 + face] = to_new[mesh.mesh.to_vert[face]];
        whole.to_neighbor[std::size_t{base} * 4 + face] = behind == kNone ? kNone : behind + base * 4;
        if (!mesh.mesh.is_fixed(face) || (behind != kNone && face > behind)) continue;
        Triangle verts = tets::verts_of(mesh.mesh, face);
        const SurfaceTriangle* found = mesh.surface.find(verts);
        const bool frozen = mesh.to_frozen[verts[0]] && mesh.to_frozen[verts[1]] && mesh.to_frozen[verts[2]];
        OpenFace open;
        if (found) {
          LinkedTriangle triangle{*found, {base + tet, behind == kNone ? kNone : base + behind / 4}};
          for (std::uint32_t& v : triangle.triangle.verts) v = to_new[v];
          open.triangle = static_cast<std::uint32_t>(triangles_[p].size());
          triangles_[p].push_back(triangle);
        }
        if (behind != kNone || !frozen) continue;
        for (std::uint32_t& v : verts) v = to_new[v];
        std::sort(verts.begin(), verts.end());
        open.verts = verts, open.face = base * 4 + face;
        open_[p].push_back(open);
      }
    }
    mesh.surface.for_each_edge([&](std::uint32_t a, std::uint32_t b, std::uint32_t edge) {
      edges_[p].push_back({{std::min(to_new[a], to_new[b]), std::max(to_new[a], to_new[b])}, edge});
    });
    part = PartOfWhole();
  }

  // Faces that two parts have; of a triangle there, the second copy goes.
  void link(WholeMesh& whole) {
    std::vector<OpenFace> all;
    for (std::size_t p = 0; p < open_.size(); ++p) {
      for (OpenFace face : open_[p]) {
        if (face.triangle != kNone) face.triangle += static_cast<std::uint32_t>(first_triangle_[p]);
        all.push_back(face);
      }
    }
    parallel_sort(all, runner_);
    std::vector<std::uint32_t> twice;
    for (std::size_t i = 0; i + 1 < all.size(); ++i) {
      const OpenFace &a = all[i], &b = all[i + 1];
      if (a.verts != b.verts) continue;
      whole.to_neighbor[a.face] = b.face, whole.to_neighbor[b.face] = a.face;
      if (a.triangle != kNone) {
        whole.triangles[a.triangle].tets[1] = b.face / 4;
        twice.push_back(b.triangle);
      }
      ++i;
    }
    std::sort(twice.begin(), twice.end());
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

  const WholeMesh& old_;
  std::vector<PartOfWhole>& parts_;
  const Cutter& cutter_;
  const TaskRunner& runner_;
  std::vector<std::uint32_t> shared_to_new_;
  std::vector<std::vector<std::uint32_t>> to_new_;
  std::vector<std::size_t> first_vert_, first_tet_, first_triangle_;
  std::vector<std::vector<LinkedTriangle>> triangles_;
  std::vector<std::vector<ModelEdgePiece>> edges_;
  std::vector<std::vector<OpenFace>> open_;
  std::uint32_t vert_count_ = 0;
  std::size_t tet_count_ = 0;
};

}  // namespace

void adapt_in_parts(WholeMesh& whole, std::span<const std::uint32_t> to_part, std::span<const float> to_work,
                    std::size_t part_count, const std::function<void(std::size_t, CavityMesh&)>& adapt,
                    const TaskRunner& runner) {
  Cutter cutter(whole, to_part, part_count, runner);
  cutter.sort();
  std::vector<double> work(part_count, 0);
  for (std::size_t tet = 0; tet < to_part.size(); ++tet) work[to_part[tet]] += double{to_work[tet]};
  std::vector<PartOfWhole> parts(part_count);
  runner.for_each_largest_first(work, [&](std::size_t p) {
    PartOfWhole& part = parts[p];
    cutter.build(static_cast<std::uint32_t>(p), part);
    adapt(p, part.mesh);
    part.to_whole.resize(part.mesh.mesh.points.size(), kNone);
    const bool has_grown = part.mesh.mesh.points.size() > part.given + part.given / 8;
    const std::vector<std::uint32_t> from = part.mesh.renumber(has_grown);
    std::vector<std::uint32_t> to_whole;
    to_whole.reserve(from.size());
    for (const std::uint32_t v : from) to_whole.push_back(part.to_whole[v]);
    part.to_whole = std::move(to_whole);
  });
  whole = Joiner(whole, parts, cutter, runner).run();
}

}  // namespace tetloom::adapt
