#include "mesher/tets/shell.hpp"

#include <algorithm>
#include <utility>

#include "core/base/disjoint_sets.hpp"
#include "core/tets/find_triangles.hpp"
#include "tetloom/tasks.hpp"

namespace tetloom::tets {

namespace {

std::vector<TriangleVerts> verts_of_all(const TetMesh& mesh, std::span<const FaceCode> faces) {
  std::vector<TriangleVerts> verts;
  verts.reserve(faces.size());
  for (const FaceCode face : faces) verts.push_back(verts_of(mesh, face));
  return verts;
}

// The open faces of a core by their vertices.
class OpenFaces {
 public:
  OpenFaces(const TetMesh& core, std::span<const FaceCode> faces, std::size_t vertex_count)
      : faces_(faces), index_(verts_of_all(core, faces), vertex_count), has_(vertex_count, 0) {
    for (const FaceCode face : faces)
      for (const std::uint32_t v : verts_of(core, face)) has_[v] = 1;
  }

  bool has_three_of(const std::uint32_t* tet) const {
    return has(tet[0]) + has(tet[1]) + has(tet[2]) + has(tet[3]) >= 3;
  }
  const TriangleIndex::Entry* find(const TriangleVerts& verts) const {
    return has(verts[0]) && has(verts[1]) && has(verts[2]) ? index_.find(sorted(verts)) : nullptr;
  }
  FaceCode face(const TriangleIndex::Entry& entry) const { return faces_[entry.triangle]; }

 private:
  int has(std::uint32_t v) const { return v < has_.size() ? has_[v] : 0; }

  std::span<const FaceCode> faces_;
  TriangleIndex index_;
  std::vector<char> has_;
};

Vec3 center_of(const TetMesh& mesh, std::uint32_t tet) {
  return 0.25 * (mesh.point_of(tet, 0) + mesh.point_of(tet, 1) + mesh.point_of(tet, 2) + mesh.point_of(tet, 3));
}

std::size_t count_points(const Surface& surface) {
  std::size_t count = 0;
  for (const TriangleVerts& verts : surface.tri_to_vert)
    count = std::max(count, std::size_t{std::max({verts[0], verts[1], verts[2]})} + 1);
  return count;
}

class Joiner {
 public:
  Joiner(TetMesh& core, TetMesh& shell, std::span<const FaceCode> open_faces, const Surface& surface,
         const TaskRunner& runner)
      : core_(core),
        shell_(shell),
        runner_(runner),
        surface_(surface),
        open_(core, open_faces, shell.points.size()),
        surface_points_(count_points(surface)),
        triangles_(surface.tri_to_vert, surface_points_) {
    core_size_ = static_cast<std::uint32_t>(core.size());
    shell_.to_region.release();
    seen_.assign(surface.tri_to_vert.size(), 0);
  }

  Fault run() {
    flood();
    for (const FaceCode face : shell_.faces()) {
      if (face.index() % (4 * kBlock) == 0) runner_.check_cancelled();
      if (shell_.is_dead(face.tet())) continue;
      if (Fault fault = name_flood(face); fault.any()) return fault;
    }
    if (Fault fault = check_sides(); fault.any()) return fault;
    number_kept();
    append_kept();
    core_.points = std::move(shell_.points);
    shell_ = TetMesh();
    flood_core();
    return {};
  }

 private:
  static constexpr std::uint32_t kBlock = 1 << 18;  // tets between two looks at the cancellation
  // What a flood was found to be, beside a region.
  static constexpr std::uint32_t kOutside = kNone, kInCore = kNone - 1, kUnnamed = kNone - 2;

  // By one pass in the order of memory, where each tet joins those before it.
  void flood() {
    to_flood_.resize(shell_.size(), kNone);
    DisjointSets sets;
    for (std::uint32_t tet = 0; tet < shell_.size(); ++tet) {
      if (tet % kBlock == 0) runner_.check_cancelled();
      if (shell_.is_dead(tet)) continue;
      std::uint32_t& flood = to_flood_[tet];
      for (const FaceCode face : FaceCode::of(tet)) {
        const FaceCode next = shell_.behind(face);
        if (!next.valid() || next.tet() >= tet || shell_.is_fixed(face)) continue;
        const std::uint32_t other = to_flood_[next.tet()];
        if (flood == kNone) {
          flood = other;
        } else if (flood != other) {
          sets.join(flood, other);
        }
      }
      if (flood == kNone) flood = sets.add();
    }
    for (std::uint32_t& flood : to_flood_)
      if (flood != kNone) flood = sets.find(flood);
    flood_to_region_.assign(sets.size(), kUnnamed);
    flood_to_namer_.assign(sets.size(), FaceCode());
  }

  Fault name_flood(FaceCode face) {
    if (!shell_.is_fixed(face) && shell_.behind(face).valid()) return {};
    std::uint32_t& name = flood_to_region_[to_flood_[face.tet()]];
    const std::uint32_t told = told_by(face);
    if (told == kUnnamed || told == name) return {};
    FaceCode& namer = flood_to_namer_[to_flood_[face.tet()]];
    if (name != kUnnamed) return contradiction(namer, face);
    name = told;
    namer = face;
    return {};
  }

  // What lies on the side of the face's tet. Open faces tell only when the core is on that side.
  std::uint32_t told_by(FaceCode face) {
    if (!shell_.is_fixed(face)) return kOutside;
    const TriangleVerts verts = verts_of(shell_, face);
    const SortedTriangle key = sorted(verts);
    if (const auto* open = open_.find(verts)) {
      met_.push_back({face, open_.face(*open)});
      return key.turned == open->turned ? kInCore : kUnnamed;
    }
    const auto* triangle = find_triangle(key);
    if (!triangle) return kUnnamed;
    // The triangle's normal points out of the tet where both run around alike.
    const bool behind = key.turned == triangle->turned;
    seen_[triangle->triangle] = static_cast<char>(seen_[triangle->triangle] | (behind ? 1 : 2));
    const FaceSides& sides = surface_.tri_to_sides[triangle->triangle];
    return (behind ? sides.back : sides.front).value;
  }

  const TriangleIndex::Entry* find_triangle(const SortedTriangle& key) const {
    return key.verts[2] < surface_points_ ? triangles_.find(key) : nullptr;
  }

  // Two faces of one flood that tell different things of it.
  Fault contradiction(FaceCode one, FaceCode other) const {
    Fault fault{"the surface does not separate its regions", {}, center_of(shell_, other.tet())};
    for (const FaceCode face : {one, other}) {
      if (!shell_.behind(face).valid()) fault.message = "a region lies outside of its surface: it is inside out";
      const auto* triangle = find_triangle(sorted(verts_of(shell_, face)));
      if (!triangle) continue;
      fault.triangles.push_back(triangle->triangle);
      const auto& [a, b, c] = surface_.tri_to_vert[triangle->triangle];
      fault.point = (shell_.points[a] + shell_.points[b] + shell_.points[c]) / 3;
    }
    return fault;
  }

  Fault check_sides() const {
    for (std::uint32_t t = 0; t < seen_.size(); ++t) {
      const FaceSides& sides = surface_.tri_to_sides[t];
      if ((sides.back.valid() && !(seen_[t] & 1)) || (sides.front.valid() && !(seen_[t] & 2)))
        return {"a side of a surface triangle was left empty", {t}, shell_.points[surface_.tri_to_vert[t][0]]};
    }
    return {};
  }

  // From here on a tet's entry is its number in the result.
  void number_kept() {
    const auto region_of = [&](std::uint32_t tet) {
      return shell_.is_dead(tet) ? kOutside : flood_to_region_[to_flood_[tet]];
    };
    std::uint32_t count = core_size_;
    for (std::uint32_t tet = 0; tet < shell_.size(); ++tet) count += region_of(tet) < kUnnamed;
    core_.to_vert.resize_for_overwrite(std::size_t{count} * 4);
    core_.to_neighbor.resize_for_overwrite(std::size_t{count} * 4);
    core_.to_region.resize(core_size_, kNone);
    core_.to_region.resize_for_overwrite(count);
    core_.to_fixed.resize(count, 0);
    to_kept_ = std::move(to_flood_);
    count = core_size_;
    for (std::uint32_t tet = 0; tet < shell_.size(); ++tet) {
      const std::uint32_t region = shell_.is_dead(tet) ? kOutside : flood_to_region_[to_kept_[tet]];
      to_kept_[tet] = region < kUnnamed ? count : kNone;
      if (region < kUnnamed) core_.to_region[count++] = region;
    }
  }

  // From the last tet to the first: what has been appended is dropped block by block, so that shell and result are
  // never there at once.
  void append_kept() {
    next_met_ = met_.size();
    for (auto end = static_cast<std::uint32_t>(shell_.size()); end > 0;) {
      runner_.check_cancelled();
      const std::uint32_t begin = (end - 1) / kBlock * kBlock;
      for (std::uint32_t tet = end; tet-- > begin;)
        if (to_kept_[tet] != kNone) append_tet(tet, to_kept_[tet]);
      shell_.to_vert.resize_for_overwrite(std::size_t{begin} * 4), shell_.to_vert.shrink_to_fit();
      shell_.to_neighbor.resize_for_overwrite(std::size_t{begin} * 4), shell_.to_neighbor.shrink_to_fit();
      end = begin;
    }
  }

  void append_tet(std::uint32_t tet, std::uint32_t kept) {
    for (std::uint32_t i = 4; i-- > 0;) {
      core_.to_vert[std::size_t{kept} * 4 + i] = shell_.to_vert[std::size_t{tet} * 4 + i];
      link({tet, i}, {kept, i});
    }
  }

  // Pre: `from` descends from call to call.
  void link(FaceCode from, FaceCode to) {
    if (shell_.is_fixed(from)) {
      while (next_met_ > 0 && met_[next_met_ - 1].shell > from) --next_met_;
      if (next_met_ > 0 && met_[next_met_ - 1].shell == from) {
        const FaceCode core = met_[next_met_ - 1].core;
        core_.behind(to) = core;
        core_.behind(core) = to;
        return;
      }
      core_.to_fixed[to.tet()] = static_cast<std::uint8_t>(core_.to_fixed[to.tet()] | 1 << to.side());
    }
    const FaceCode behind = shell_.behind(from);
    const std::uint32_t next = !behind.valid() ? kNone : to_kept_[behind.tet()];
    core_.behind(to) = next == kNone ? FaceCode() : behind.of_tet(next);
  }

  // kNone when there are several.
  std::uint32_t only_region() const {
    std::uint32_t only = kNone;
    for (const std::uint32_t region : flood_to_region_) {
      if (region >= kUnnamed || region == only) continue;
      if (only != kNone) return kNone;
      only = region;
    }
    return only;
  }

  void flood_core() {
    std::vector<std::uint32_t> stack;
    if (const std::uint32_t only = only_region(); only != kNone) {
      std::fill(core_.to_region.begin(), core_.to_region.begin() + core_size_, only);
      return;
    }
    for (auto tet = core_size_; tet < core_.size(); ++tet) stack.push_back(tet);
    while (!stack.empty()) {
      const std::uint32_t tet = stack.back();
      stack.pop_back();
      for (std::uint32_t i = 0; i < 4; ++i) {
        const FaceCode next = core_.behind({tet, i});
        if (!next.valid() || core_.to_region[next.tet()] != kNone) continue;
        core_.to_region[next.tet()] = core_.to_region[tet];
        stack.push_back(next.tet());
      }
    }
  }

  TetMesh& core_;
  TetMesh& shell_;
  const TaskRunner& runner_;
  const Surface& surface_;
  OpenFaces open_;
  std::size_t surface_points_;  // those of higher ids are of no triangle
  TriangleIndex triangles_;
  std::uint32_t core_size_ = 0;
  GrowingArray<std::uint32_t> to_flood_, to_kept_;  // one after the other
  std::vector<std::uint32_t> flood_to_region_;
  std::vector<FaceCode> flood_to_namer_;  // the face that told what the flood is
  // Faces of the shell that are open faces of the core, ascending; where appending has come to.
  struct Meeting {
    FaceCode shell, core;
  };
  std::vector<Meeting> met_;
  std::size_t next_met_ = 0;
  std::vector<char> seen_;  // per triangle: 1 from behind, 2 from in front
};

}  // namespace

std::size_t fix_core_faces(TetMesh& shell, const TetMesh& core, std::span<const FaceCode> open_faces) {
  const OpenFaces open(core, open_faces, shell.points.size());
  const auto fix = [&shell](FaceCode face) {
    shell.to_fixed[face.tet()] = static_cast<std::uint8_t>(shell.to_fixed[face.tet()] | 1 << face.side());
  };
  std::size_t found = 0;
  for (std::uint32_t tet = 0; tet < shell.size(); ++tet) {
    if (shell.is_dead(tet) || !open.has_three_of(&shell.to_vert[std::size_t{tet} * 4])) continue;
    for (const FaceCode face : FaceCode::of(tet)) {
      const FaceCode behind = shell.behind(face);
      if (behind < face || !open.find(verts_of(shell, face))) continue;
      fix(face);
      if (behind.valid()) fix(behind);
      ++found;
    }
  }
  return open_faces.size() - found;
}

Fault join_shell(TetMesh& core, TetMesh&& shell, std::span<const FaceCode> open_faces, const Surface& surface,
                 const TaskRunner& runner) {
  return Joiner(core, shell, open_faces, surface, runner).run();
}

}  // namespace tetloom::tets
