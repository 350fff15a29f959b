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
  const std::uint32_t tet = places_.take(mesh_);
  if (tet == to_quality_.size()) to_quality_.push_back(kDeadQuality);
  return tet;
}

void WorkingMesh::drop_tet(std::uint32_t tet) {
  places_.drop(mesh_, tet);
  to_quality_[tet] = kDeadQuality;
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
  const FaceCode opposite = mesh_.to_neighbor[std::size_t{tet} * 4 + face];
  const std::uint32_t other = opposite / 4, region = mesh_.to_region[tet];
  const std::uint32_t apex = verts(tet)[face], beyond = mesh_.to_vert[opposite];
  const TriangleVerts edge = verts_of(mesh_, tet * 4 + face);
  filling_.open(mesh_, std::array{tet, other}, 3);
  const std::array<std::uint32_t, 3> ids{tet, other, take_tet()};
  for (std::size_t i = 0; i < 3; ++i)
    write_tet(ids[i], {{edge[(i + 1) % 3], edge[(i + 2) % 3], apex, beyond}, qualities[i]}, region);
  close(ids);
}

void WorkingMesh::replace(std::span<const std::uint32_t> old, std::span<const NewTet> made) {
  const std::uint32_t region = mesh_.to_region[old[0]];
  filling_.open(mesh_, old, made.size());
  const auto ids = take_ids(old, made.size());
  for (std::size_t i = 0; i < made.size(); ++i) write_tet(ids[i], made[i], region);
  close(std::span(ids).first(made.size()));
}

void WorkingMesh::replace_at_surface(const SurfaceSwap& swap, const std::array<CavitySide, 2>& sides) {
  std::array<std::uint32_t, kMostTets> old;
  std::size_t old_count = 0;
  const std::size_t made_count = sides[0].made.size() + sides[1].made.size();
  std::array<std::uint32_t, 2> regions{kNone, kNone};
  for (std::size_t side = 0; side < 2; ++side)
    for (const std::uint32_t tet : sides[side].old) old[old_count++] = tet, regions[side] = mesh_.to_region[tet];
  filling_.open(mesh_, std::span(old).first(old_count), made_count);
  filling_.swap_surface(swap.before, swap.after);
  const auto ids = take_ids(std::span(old).first(old_count), made_count);
  const std::uint32_t* id = ids.data();
  for (std::size_t side = 0; side < 2; ++side)
    for (const NewTet& made : sides[side].made) write_tet(*id++, made, regions[side]);
  close(std::span(ids).first(made_count));
}

void WorkingMesh::close(std::span<const std::uint32_t> made) {
  [[maybe_unused]] const bool fits = filling_.close(mesh_, made);
  TETLOOM_DEBUG_ASSERT(fits);
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
