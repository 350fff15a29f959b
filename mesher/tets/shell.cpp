#include "mesher/tets/shell.hpp"

#include <algorithm>
#include <utility>

namespace tetloom::tets {

namespace {

// Faces of a mesh by their vertices, and which vertices they have.
class FaceIndex {
 public:
  FaceIndex(const TetMesh& mesh, std::span<const FaceCode> faces, std::size_t vertex_count)
      : table_(faces.size()), has_(vertex_count, 0) {
    for (const FaceCode face : faces) {
      const TriangleVerts verts = verts_of(mesh, face);
      table_.add(verts, face);
      for (const std::uint32_t v : verts) has_[v] = 1;
    }
  }
  const TriangleTable::Entry* find(const TriangleVerts& verts) const {
    for (const std::uint32_t v : verts) {
      if (v >= has_.size() || !has_[v]) return nullptr;
    }
    return table_.find(sorted(verts));
  }

 private:
  TriangleTable table_;
  std::vector<char> has_;
};

Vec3 center_of(const TetMesh& mesh, std::uint32_t tet) {
  return 0.25 * (mesh.point_of(tet, 0) + mesh.point_of(tet, 1) + mesh.point_of(tet, 2) + mesh.point_of(tet, 3));
}

class Joiner {
 public:
  Joiner(TetMesh& core, TetMesh& shell, std::span<const FaceCode> open_faces, const Surface& surface)
      : core_(core),
        shell_(shell),
        surface_(surface),
        open_(core, open_faces, shell.points.size()),
        tri_table_(surface.tri_to_vert.size()) {
    for (std::uint32_t t = 0; t < surface.tri_to_vert.size(); ++t) tri_table_.add(surface.tri_to_vert[t], t);
    core_size_ = static_cast<std::uint32_t>(core.size());
    shell_.to_region.release();
    seen_.assign(surface.tri_to_vert.size(), 0);
  }

  Fault run() {
    flood();
    for (FaceCode face = 0; face < shell_.to_neighbor.size(); ++face) {
      if (shell_.is_dead(face / 4)) continue;
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
  // What a flood was found to be, beside a region.
  static constexpr std::uint32_t kOutside = kNone, kInCore = kNone - 1, kUnnamed = kNone - 2;

  void flood() {
    to_flood_.resize(shell_.size(), kNone);
    std::vector<std::uint32_t> stack;
    for (std::uint32_t seed = 0; seed < shell_.size(); ++seed) {
      if (to_flood_[seed] != kNone || shell_.is_dead(seed)) continue;
      const auto color = static_cast<std::uint32_t>(flood_to_region_.size());
      flood_to_region_.push_back(kUnnamed);
      flood_to_namer_.push_back(kNone);
      to_flood_[seed] = color;
      stack.push_back(seed);
      while (!stack.empty()) {
        const std::uint32_t tet = stack.back();
        stack.pop_back();
        for (FaceCode face = 4 * tet; face < 4 * tet + 4; ++face) {
          const FaceCode next = shell_.to_neighbor[face];
          if (next == kNone || shell_.is_fixed(face) || to_flood_[next / 4] != kNone) continue;
          to_flood_[next / 4] = color;
          stack.push_back(next / 4);
        }
      }
    }
  }

  Fault name_flood(FaceCode face) {
    if (!shell_.is_fixed(face) && shell_.to_neighbor[face] != kNone) return {};
    std::uint32_t& name = flood_to_region_[to_flood_[face / 4]];
    const std::uint32_t told = told_by(face);
    if (told == kUnnamed || told == name) return {};
    FaceCode& namer = flood_to_namer_[to_flood_[face / 4]];
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
    if (const auto* open = open_.find(verts)) return key.turned == open->turned ? kInCore : kUnnamed;
    const auto* triangle = tri_table_.find(key);
    if (!triangle) return kUnnamed;
    // The triangle's normal points out of the tet where both run around alike.
    const bool behind = key.turned == triangle->turned;
    seen_[triangle->value] = static_cast<char>(seen_[triangle->value] | (behind ? 1 : 2));
    const FaceSides& sides = surface_.tri_to_sides[triangle->value];
    return (behind ? sides.back : sides.front).value;
  }

  // Two faces of one flood that tell different things of it.
  Fault contradiction(FaceCode one, FaceCode other) const {
    Fault fault{"the surface does not separate its regions", {}, center_of(shell_, other / 4)};
    for (const FaceCode face : {one, other}) {
      if (shell_.to_neighbor[face] == kNone) fault.message = "a region lies outside of its surface: it is inside out";
      const auto* triangle = tri_table_.find(sorted(verts_of(shell_, face)));
      if (!triangle) continue;
      fault.triangles.push_back(triangle->value);
      const auto& [a, b, c] = surface_.tri_to_vert[triangle->value];
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

  bool is_kept(std::uint32_t tet) const { return !shell_.is_dead(tet) && flood_to_region_[to_flood_[tet]] < kUnnamed; }

  void number_kept() {
    std::uint32_t count = core_size_;
    to_kept_.resize(shell_.size(), kNone);
    for (std::uint32_t tet = 0; tet < shell_.size(); ++tet) {
      if (is_kept(tet)) to_kept_[tet] = count++;
    }
    core_.to_vert.resize_for_overwrite(std::size_t{count} * 4);
    core_.to_neighbor.resize_for_overwrite(std::size_t{count} * 4);
    core_.to_region.resize_for_overwrite(count);
    core_.to_fixed.resize(count, 0);
  }

  void append_kept() {
    for (std::uint32_t tet = 0; tet < shell_.size(); ++tet) {
      const std::uint32_t kept = to_kept_[tet];
      if (kept == kNone) continue;
      core_.to_region[kept] = flood_to_region_[to_flood_[tet]];
      for (std::uint32_t i = 0; i < 4; ++i) {
        core_.to_vert[std::size_t{kept} * 4 + i] = shell_.to_vert[std::size_t{tet} * 4 + i];
        link(tet * 4 + i, kept * 4 + i);
      }
    }
  }

  void link(FaceCode from, FaceCode to) {
    const bool fixed = shell_.is_fixed(from);
    if (fixed) {
      if (const auto* open = open_.find(verts_of(shell_, from))) {
        core_.to_neighbor[to] = open->value;
        core_.to_neighbor[open->value] = to;
        return;
      }
      core_.to_fixed[to / 4] = static_cast<std::uint8_t>(core_.to_fixed[to / 4] | 1 << to % 4);
    }
    const FaceCode behind = shell_.to_neighbor[from];
    const std::uint32_t next = behind == kNone ? kNone : to_kept_[behind / 4];
    core_.to_neighbor[to] = next == kNone ? kNone : next * 4 + behind % 4;
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
        const FaceCode next = core_.to_neighbor[std::size_t{tet} * 4 + i];
        if (next == kNone || core_.to_region[next / 4] != kNone) continue;
        core_.to_region[next / 4] = core_.to_region[tet];
        stack.push_back(next / 4);
      }
    }
  }

  TetMesh& core_;
  TetMesh& shell_;
  const Surface& surface_;
  FaceIndex open_;
  TriangleTable tri_table_;
  std::uint32_t core_size_ = 0;
  GrowingArray<std::uint32_t> to_flood_, to_kept_;
  std::vector<std::uint32_t> flood_to_region_;
  std::vector<FaceCode> flood_to_namer_;  // the face that told what the flood is
  std::vector<char> seen_;                // per triangle: 1 from behind, 2 from in front
};

}  // namespace

std::size_t fix_core_faces(TetMesh& shell, const TetMesh& core, std::span<const FaceCode> open_faces) {
  const FaceIndex open(core, open_faces, shell.points.size());
  std::size_t found = 0;
  for (FaceCode face = 0; face < shell.to_neighbor.size(); ++face) {
    if (!open.find(verts_of(shell, face))) continue;
    shell.to_fixed[face / 4] = static_cast<std::uint8_t>(shell.to_fixed[face / 4] | 1 << face % 4);
    ++found;
  }
  return open_faces.size() - found / 2;
}

Fault join_shell(TetMesh& core, TetMesh&& shell, std::span<const FaceCode> open_faces, const Surface& surface) {
  return Joiner(core, shell, open_faces, surface).run();
}

}  // namespace tetloom::tets
