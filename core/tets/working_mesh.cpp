#include "core/tets/working_mesh.hpp"

#include <algorithm>

#include "core/tets/many_values.hpp"

namespace tetloom::tets {

namespace {

using Triangle = std::array<std::uint32_t, 3>;

Triangle sorted(std::uint32_t a, std::uint32_t b, std::uint32_t c) {
  if (a > b) std::swap(a, b);
  if (b > c) std::swap(b, c);
  if (a > b) std::swap(a, b);
  return {a, b, c};
}

Triangle face_key(const std::uint32_t* verts, std::uint32_t face) {
  const auto& corners = kFaceVerts[face];
  return sorted(verts[corners[0]], verts[corners[1]], verts[corners[2]]);
}

Triangle sorted(const Triangle& t) { return sorted(t[0], t[1], t[2]); }

// A face on the boundary of a cavity, or of a new tet: `code` is the face behind it, or the new face.
struct CavityFace {
  Triangle key;
  FaceCode code;
  bool is_outer, is_fixed;

  friend bool operator<(const CavityFace& a, const CavityFace& b) {
    if (a.key != b.key) return a.key < b.key;
    return a.code < b.code;
  }
};

// The faces of one replacement, without allocation.
class FaceList {
 public:
  void add(const CavityFace& face) { faces_[count_++] = face; }
  // Forgets `key` where nothing lies behind it.
  void drop_open(const Triangle& key) {
    for (std::size_t i = 0; i < count_; ++i) {
      if (faces_[i].key == key && faces_[i].code == kNone) faces_[i--] = faces_[--count_];
    }
  }
  std::span<CavityFace> faces() { return {faces_.data(), count_}; }

 private:
  std::array<CavityFace, WorkingMesh::kMostTets * 8> faces_;
  std::size_t count_ = 0;
};

void collect_outer_faces(const TetMesh& mesh, std::span<const std::uint32_t> old, FaceList& list) {
  for (const std::uint32_t tet : old) {
    for (std::uint32_t i = 0; i < 4; ++i) {
      const FaceCode behind = mesh.to_neighbor[std::size_t{tet} * 4 + i];
      const bool inner = behind != kNone && std::find(old.begin(), old.end(), behind / 4) != old.end();
      if (inner) continue;
      list.add({face_key(&mesh.to_vert[std::size_t{tet} * 4], i), behind, true, mesh.is_fixed(tet * 4 + i)});
    }
  }
}

void fix(TetMesh& mesh, FaceCode face) { mesh.to_fixed[face / 4] |= static_cast<std::uint8_t>(1u << face % 4); }

void link(TetMesh& mesh, const CavityFace& a, const CavityFace& b) {
  const CavityFace& inner = a.is_outer ? b : a;
  const CavityFace& other = a.is_outer ? a : b;
  TETLOOM_DEBUG_ASSERT(a.key == b.key && !inner.is_outer);
  mesh.to_neighbor[inner.code] = other.code;
  if (other.code != kNone) mesh.to_neighbor[other.code] = inner.code;
  if (other.is_fixed) fix(mesh, inner.code);
}

// Links faces in pairs, but for those of `fixed` with a tet on one side only.
void link_all(TetMesh& mesh, std::span<CavityFace> faces, const std::array<Triangle, 2>& fixed) {
  std::sort(faces.begin(), faces.end());
  for (std::size_t i = 0; i < faces.size();) {
    const bool is_fixed = faces[i].key == fixed[0] || faces[i].key == fixed[1];
    const std::size_t count = i + 1 < faces.size() && faces[i + 1].key == faces[i].key ? 2 : 1;
    TETLOOM_DEBUG_ASSERT(count == 2 || is_fixed);
    if (count == 2) {
      link(mesh, faces[i], faces[i + 1]);
    } else {
      mesh.to_neighbor[faces[i].code] = kNone;
    }
    for (std::size_t k = i; is_fixed && k < i + count; ++k) fix(mesh, faces[k].code);
    i += count;
  }
}

}  // namespace

WorkingMesh::WorkingMesh(TetMesh& mesh, std::uint32_t fixed_points, std::uint32_t alike,
                         std::span<const FaceCode> open_faces)
    : mesh_(mesh) {
  fixed_.resize(mesh.points.size() / 64 + 1);
  for (std::uint32_t v = 0; v < fixed_points; ++v) set_fixed_point(v);
  const auto count = static_cast<std::uint32_t>(mesh.size());
  to_quality_.reserve(count + count / 64);
  to_quality_.resize_for_overwrite(count);
  if (alike > 0) {
    read_tet(0);
    std::fill(to_quality_.begin(), to_quality_.begin() + alike, to_quality_[0]);
  }
  for (const FaceCode face : open_faces)
    for (const std::uint8_t corner : kFaceVerts[face % 4]) set_fixed_point(verts(face / 4)[corner]);
  for (std::uint32_t tet = alike; tet < count; ++tet) {
    if (mesh.is_dead(tet)) {
      drop_tet(tet);
    } else {
      read_tet(tet);
    }
  }
}

WorkingMesh::WorkingMesh(TetMesh& mesh, GrowingArray<float>&& qualities)
    : mesh_(mesh), to_quality_(std::move(qualities)) {
  TETLOOM_DEBUG_ASSERT(to_quality_.size() == mesh.size());
}

void WorkingMesh::find_fixed_points() {
  if (!fixed_.empty()) return;
  fixed_.resize(mesh_.points.size() / 64 + 1);
  for (std::uint32_t tet = 0; tet < to_quality_.size(); ++tet)
    if (!mesh_.is_dead(tet)) fix_points_of(tet);
}

void WorkingMesh::read_tet(std::uint32_t tet) {
  const std::uint32_t* v = &mesh_.to_vert[std::size_t{tet} * 4];
  set_quality(tet, cubed_quality(point(v[0]), point(v[1]), point(v[2]), point(v[3])));
  fix_points_of(tet);
}

void WorkingMesh::fix_points_of(std::uint32_t tet) {
  const std::uint32_t* v = &mesh_.to_vert[std::size_t{tet} * 4];
  for (std::uint32_t face = 0; face < 4; ++face) {
    if (mesh_.to_neighbor[std::size_t{tet} * 4 + face] != kNone && !mesh_.is_fixed(tet * 4 + face)) continue;
    for (const std::uint8_t corner : kFaceVerts[face]) set_fixed_point(v[corner]);
  }
}

std::uint32_t WorkingMesh::take_tet() {
  if (first_dead_ != kNone) {
    const std::uint32_t tet = first_dead_;
    first_dead_ = mesh_.to_neighbor[std::size_t{tet} * 4];
    return tet;
  }
  const std::size_t tet = mesh_.size();
  mesh_.to_vert.resize_for_overwrite((tet + 1) * 4);
  mesh_.to_neighbor.resize_for_overwrite((tet + 1) * 4);
  mesh_.to_region.push_back(kNone);
  mesh_.to_fixed.push_back(0);
  to_quality_.push_back(kDeadQuality);
  return static_cast<std::uint32_t>(tet);
}

void WorkingMesh::drop_tet(std::uint32_t tet) {
  mesh_.to_vert[std::size_t{tet} * 4] = kNone;
  mesh_.to_neighbor[std::size_t{tet} * 4] = first_dead_;
  mesh_.to_fixed[tet] = 0;
  to_quality_[tet] = kDeadQuality;
  first_dead_ = tet;
}

void WorkingMesh::write_tet(std::uint32_t tet, const NewTet& made, std::uint32_t region) {
  std::copy(made.verts.begin(), made.verts.end(), &mesh_.to_vert[std::size_t{tet} * 4]);
  mesh_.to_region[tet] = region;
  mesh_.to_fixed[tet] = 0;
  set_quality(tet, made.quality);
}

// Of `count` tets in the place of `old`.
std::array<std::uint32_t, WorkingMesh::kMostTets> WorkingMesh::take_ids(std::span<const std::uint32_t> old,
                                                                        std::size_t count) {
  std::array<std::uint32_t, kMostTets> ids;
  std::copy(old.begin(), old.end(), ids.begin());
  std::sort(ids.begin(), ids.begin() + static_cast<std::ptrdiff_t>(old.size()));
  for (std::size_t i = count; i < old.size(); ++i) drop_tet(ids[i]);
  for (std::size_t i = old.size(); i < count; ++i) ids[i] = take_tet();
  return ids;
}

void WorkingMesh::replace_ring(const EdgeRing& ring, std::span<const RingTriangle> triangles) {
  const RingFilling filling(mesh_, ring);
  const auto ids = take_ids(ring.old(), 2 * triangles.size());
  filling.fill(mesh_, triangles, std::span(ids).first(2 * triangles.size()));
  const Vec3 origin = point(ring.a);
  for (const std::uint32_t tet : std::span(ids).first(2 * triangles.size())) {
    const auto v = verts(tet);
    set_quality(tet,
                cubed_quality(point(v[0]) - origin, point(v[1]) - origin, point(v[2]) - origin, point(v[3]) - origin));
  }
}

void WorkingMesh::replace_face(std::uint32_t tet, std::uint32_t face, const std::array<double, 3>& qualities) {
  struct Side {
    FaceCode behind;
    bool is_fixed;
  };
  const FaceCode opposite = mesh_.to_neighbor[std::size_t{tet} * 4 + face];
  const std::uint32_t other = opposite / 4, region = mesh_.to_region[tet];
  const std::uint32_t apex = verts(tet)[face], beyond = mesh_.to_vert[opposite];
  std::array<std::uint32_t, 3> edge;
  std::array<std::array<Side, 3>, 2> sides;  // behind the faces opposite to the common vertices, of either tet
  for (std::size_t i = 0; i < 3; ++i) {
    edge[i] = verts(tet)[kFaceVerts[face][i]];
    const std::array<FaceCode, 2> codes{tet * 4 + kFaceVerts[face][i], other * 4 + corner_of(other, edge[i])};
    for (std::size_t k = 0; k < 2; ++k) sides[k][i] = {mesh_.to_neighbor[codes[k]], mesh_.is_fixed(codes[k])};
  }
  const std::array<std::uint32_t, 3> ids{tet, other, take_tet()};
  for (std::size_t i = 0; i < 3; ++i) {
    const std::size_t next = (i + 1) % 3, last = (i + 2) % 3;
    write_tet(ids[i], {{edge[next], edge[last], apex, beyond}, qualities[i]}, region);
    FaceCode* const behind = &mesh_.to_neighbor[std::size_t{ids[i]} * 4];
    behind[0] = ids[next] * 4 + 1, behind[1] = ids[last] * 4;
    for (std::uint32_t k = 0; k < 2; ++k) {
      const Side& side = sides[k][i];
      const FaceCode own = ids[i] * 4 + 3 - k;
      mesh_.to_neighbor[own] = side.behind;
      if (side.behind != kNone) mesh_.to_neighbor[side.behind] = own;
      if (side.is_fixed) fix(mesh_, own);
    }
  }
}

void WorkingMesh::replace(std::span<const std::uint32_t> old, std::span<const NewTet> made) {
  FaceList list;
  collect_outer_faces(mesh_, old, list);
  const std::uint32_t region = mesh_.to_region[old[0]];
  const auto ids = take_ids(old, made.size());
  for (std::size_t i = 0; i < made.size(); ++i) {
    const std::uint32_t tet = ids[i];
    write_tet(tet, made[i], region);
    for (std::uint32_t f = 0; f < 4; ++f) list.add({face_key(made[i].verts.data(), f), tet * 4 + f, false, false});
  }
  const std::span<CavityFace> faces = list.faces();
  std::sort(faces.begin(), faces.end());
  TETLOOM_DEBUG_ASSERT(faces.size() % 2 == 0);
  for (std::size_t i = 0; i < faces.size(); i += 2) link(mesh_, faces[i], faces[i + 1]);
}

void WorkingMesh::replace_at_surface(const SurfaceSwap& swap, const std::array<CavitySide, 2>& sides) {
  std::array<std::uint32_t, kMostTets> ids;
  std::size_t old_count = 0, made_count = sides[0].made.size() + sides[1].made.size();
  std::array<std::uint32_t, 2> regions{kNone, kNone};
  for (std::size_t side = 0; side < 2; ++side) {
    for (const std::uint32_t tet : sides[side].old) ids[old_count++] = tet, regions[side] = mesh_.to_region[tet];
  }
  std::sort(ids.begin(), ids.begin() + static_cast<std::ptrdiff_t>(old_count));
  FaceList list;
  collect_outer_faces(mesh_, std::span(ids).first(old_count), list);
  list.drop_open(sorted(swap.before[0])), list.drop_open(sorted(swap.before[1]));
  for (std::size_t i = made_count; i < old_count; ++i) drop_tet(ids[i]);
  for (std::size_t i = old_count; i < made_count; ++i) ids[i] = take_tet();
  const std::uint32_t* id = ids.data();
  for (std::size_t side = 0; side < 2; ++side) {
    for (const NewTet& made : sides[side].made) {
      write_tet(*id, made, regions[side]);
      for (std::uint32_t f = 0; f < 4; ++f) list.add({face_key(made.verts.data(), f), *id * 4 + f, false, false});
      ++id;
    }
  }
  link_all(mesh_, list.faces(), {sorted(swap.after[0]), sorted(swap.after[1])});
}

std::uint32_t WorkingMesh::add_point(const Vec3& point) {
  if (!unused_points_.empty()) {
    const std::uint32_t vertex = unused_points_.back();
    unused_points_.resize(unused_points_.size() - 1);
    mesh_.points[vertex] = point;
    return vertex;
  }
  mesh_.points.push_back(point);
  if (mesh_.points.size() > fixed_.size() * 64) fixed_.push_back(0);
  return static_cast<std::uint32_t>(mesh_.points.size() - 1);
}

std::vector<std::uint32_t> WorkingMesh::find_dead() const {
  std::vector<std::uint32_t> dead;
  const float* qualities = to_quality_.data();
  for_each_that(
      0, to_quality_.size(), [qualities](std::size_t tet) { return qualities[tet] == kDeadQuality; },
      [&](std::size_t tet) { dead.push_back(static_cast<std::uint32_t>(tet)); });
  return dead;
}

// As compact does it with the tets.
void WorkingMesh::compact_qualities(std::span<const std::uint32_t> dead) {
  std::size_t count = to_quality_.size();
  for (const std::uint32_t hole : dead) {
    if (hole >= count) break;
    while (count > hole + 1 && to_quality_[count - 1] == kDeadQuality) --count;
    --count;
    if (count > hole) to_quality_[hole] = to_quality_[count];
  }
  to_quality_.resize(count);
}

void WorkingMesh::finish(bool keep_points) {
  const std::vector<std::uint32_t> dead = find_dead();
  compact_qualities(dead);
  compact(mesh_, dead);
  if (unused_points_.empty() || keep_points) return;
  std::sort(unused_points_.begin(), unused_points_.end());
  GrowingArray<std::uint32_t> to_new;
  to_new.resize_for_overwrite(mesh_.points.size());
  for (std::uint32_t v = 0; v < to_new.size(); ++v) to_new[v] = v;
  std::size_t count = mesh_.points.size(), last_unused = unused_points_.size();
  for (std::size_t i = 0; i < last_unused; ++i) {
    while (last_unused > i && unused_points_[last_unused - 1] == count - 1) --count, --last_unused;
    if (i >= last_unused) break;
    --count;
    mesh_.points[unused_points_[i]] = mesh_.points[count];
    to_new[count] = unused_points_[i];
  }
  mesh_.points.resize(count);
  for (std::uint32_t& v : mesh_.to_vert) v = to_new[v];
  unused_points_.clear();
}

}  // namespace tetloom::tets
