#include "core/tets/working_mesh.hpp"

#include <algorithm>

#include "core/tets/many_values.hpp"

namespace tetloom::tets {

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
    for (const std::uint8_t corner : kFaceVerts[face.side()]) set_fixed_point(verts(face.tet())[corner]);
  for (std::uint32_t tet = alike; tet < count; ++tet) {
    if (mesh.is_dead(tet)) {
      editor_.drop(mesh, &to_quality_, tet);
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
    if (mesh_.behind({tet, face}).valid() && !mesh_.is_fixed({tet, face})) continue;
    for (const std::uint8_t corner : kFaceVerts[face]) set_fixed_point(v[corner]);
  }
}

void WorkingMesh::replace_ring(const EdgeRing& ring, std::span<const RingTriangle> triangles) {
  std::array<NewTet, kMostTets> made;
  std::size_t count = 0;
  const Vec3 origin = point(ring.a);
  for (const RingTriangle& triangle : triangles)
    for (const auto& v : tets_over(ring, triangle))
      made[count++] = {
          v, cubed_quality(point(v[0]) - origin, point(v[1]) - origin, point(v[2]) - origin, point(v[3]) - origin)};
  replace(ring.old(), std::span(made).first(count));
}

void WorkingMesh::replace_face(std::uint32_t tet, std::uint32_t face, const std::array<double, 3>& qualities) {
  const FaceCode opposite = mesh_.behind({tet, face});
  const std::uint32_t apex = verts(tet)[face], beyond = mesh_.apex(opposite);
  const TriangleVerts edge = verts_of(mesh_, {tet, face});
  std::array<NewTet, 3> made;
  for (std::size_t i = 0; i < 3; ++i) made[i] = {{edge[(i + 1) % 3], edge[(i + 2) % 3], apex, beyond}, qualities[i]};
  editor_.replace(mesh_, &to_quality_, {std::array{tet, opposite.tet()}, made});
}

void WorkingMesh::replace(std::span<const std::uint32_t> old, std::span<const NewTet> made) {
  std::array<std::uint32_t, kMostTets> ids;
  const auto end = std::copy(old.begin(), old.end(), ids.begin());
  std::sort(ids.begin(), end);
  editor_.replace(mesh_, &to_quality_, {std::span(ids.begin(), end), made});
}

void WorkingMesh::replace_at_surface(const SurfaceSwap& swap, const std::array<CavitySide, 2>& sides) {
  std::array<std::uint32_t, kMostTets> old, regions;
  std::array<NewTet, kMostTets> made;
  std::size_t old_count = 0, made_count = 0;
  for (const CavitySide& side : sides) {
    for (const NewTet& tet : side.made) {
      made[made_count] = tet;
      regions[made_count++] = mesh_.to_region[side.old[0]];
    }
    for (const std::uint32_t tet : side.old) old[old_count++] = tet;
  }
  const auto ids = std::span(old).first(old_count);
  std::ranges::sort(ids);
  editor_.replace(
      mesh_, &to_quality_,
      {ids, std::span(made).first(made_count), std::span(regions).first(made_count), swap.before, swap.after});
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

void WorkingMesh::finish(bool keep_points) {
  const std::vector<std::uint32_t> dead = find_dead();
  to_quality_.resize(fill_holes(to_quality_.size(), dead,
                                [this](std::uint32_t from, std::uint32_t to) { to_quality_[to] = to_quality_[from]; }));
  compact(mesh_, dead);
  editor_.forget_dead();
  if (unused_points_.empty() || keep_points) return;
  std::sort(unused_points_.begin(), unused_points_.end());
  GrowingArray<std::uint32_t> to_new;
  to_new.resize_for_overwrite(mesh_.points.size());
  for (std::uint32_t v = 0; v < to_new.size(); ++v) to_new[v] = v;
  mesh_.points.resize(fill_holes(mesh_.points.size(), unused_points_, [&](std::uint32_t from, std::uint32_t to) {
    mesh_.points[to] = mesh_.points[from];
    to_new[from] = to;
  }));
  for (std::uint32_t& v : mesh_.to_vert) v = to_new[v];
  unused_points_.clear();
}

}  // namespace tetloom::tets
