#include "core/tets/local_mesh.hpp"

#include <algorithm>

namespace tetloom::tets {

LocalMesh::LocalMesh(TetMesh& mesh) : mesh_(mesh), vert_to_tet_(mesh.points.size(), kNone) {
  for (auto t = static_cast<std::uint32_t>(mesh.size()); t-- > 0;)
    if (mesh.is_dead(t)) editor_.drop(mesh, nullptr, t);
  for (std::uint32_t t = 0; t < mesh.size(); ++t) {
    if (mesh.is_dead(t)) continue;
    for (const std::uint32_t v : tet(t)) vert_to_tet_[v] = t;
  }
  stamps_.assign(mesh.size(), 0);
}

Tet LocalMesh::tet(std::uint32_t t) const {
  const std::uint32_t* v = mesh_.to_vert.data() + std::size_t{t} * 4;
  return {v[0], v[1], v[2], v[3]};
}

std::uint32_t LocalMesh::corner_of(std::uint32_t t, std::uint32_t v) const {
  const Tet verts = tet(t);
  return static_cast<std::uint32_t>(std::find(verts.begin(), verts.end(), v) - verts.begin());
}

TriangleVerts LocalMesh::face(FaceCode code) const {
  const TriangleVerts v = verts_of(mesh_, code);
  return {v[0], v[2], v[1]};
}

template <class Keep>
void LocalMesh::flood(std::uint32_t seed, const Keep& keep, TetList& tets) const {
  if (++stamp_ == 0) {
    std::fill(stamps_.begin(), stamps_.end(), 0u);
    stamp_ = 1;
  }
  tets.assign(1, seed);
  stamps_[seed] = stamp_;
  for (std::size_t i = 0; i < tets.size(); ++i) {
    for (std::uint32_t k = 0; k < 4; ++k) {
      const FaceCode back = mesh_.behind({tets[i], k});
      if (!back.valid() || stamps_[back.tet()] == stamp_ || !keep(back.tet())) continue;
      stamps_[back.tet()] = stamp_;
      tets.push_back(back.tet());
    }
  }
}

TetList LocalMesh::find_ball(std::uint32_t v) const {
  TetList tets;
  if (v < vert_to_tet_.size() && vert_to_tet_[v] != kNone)
    flood(
        vert_to_tet_[v], [&](std::uint32_t t) { return has(t, v); }, tets);
  return tets;
}

TetList LocalMesh::find_shell(std::uint32_t a, std::uint32_t b) const {
  TetList shell;
  for (const std::uint32_t t : find_ball(a)) {
    if (has(t, b)) shell.push_back(t);
  }
  return shell;
}

FaceCode LocalMesh::find_face(const TriangleVerts& triangle) const {
  const auto& [a, b, c] = triangle;
  for (const std::uint32_t t : find_ball(a)) {
    if (!has(t, b) || !has(t, c)) continue;
    const Tet v = tet(t);
    for (std::uint32_t i = 0; i < 4; ++i) {
      if (v[i] == a || v[i] == b || v[i] == c) continue;
      const TriangleVerts f = face({t, i});
      const auto at = static_cast<std::size_t>(std::find(f.begin(), f.end(), a) - f.begin());
      if (f[(at + 1) % 3] == b) return {t, i};
      if (mesh_.behind({t, i}).valid()) return mesh_.behind({t, i});
    }
  }
  return {};
}

void LocalMesh::fix(FaceCode code) {
  for (const FaceCode side : {code, mesh_.behind(code)}) {
    if (side.valid()) fix_side(mesh_, side);
  }
}

void LocalMesh::release(FaceCode code) {
  for (const FaceCode side : {code, mesh_.behind(code)}) {
    if (side.valid())
      mesh_.to_fixed[side.tet()] = static_cast<std::uint8_t>(mesh_.to_fixed[side.tet()] & ~(1u << side.side()));
  }
}

void LocalMesh::replace(std::span<const std::uint32_t> old, std::span<const Tet> fresh) {
  TetList inside(old.begin(), old.end());
  std::sort(inside.begin(), inside.end());
  for (const std::uint32_t t : inside)
    for (const std::uint32_t v : tet(t)) vert_to_tet_[v] = kNone;
  // Of those that die, the lowest is to be taken again first.
  std::reverse(inside.begin() + static_cast<std::ptrdiff_t>(std::min(inside.size(), fresh.size())), inside.end());
  std::vector<NewTet> made;
  for (const Tet& verts : fresh) made.push_back({verts, 0});
  for (const std::uint32_t t : editor_.replace(mesh_, nullptr, {inside, made}))
    for (const std::uint32_t v : tet(t)) vert_to_tet_[v] = t;
  stamps_.resize(mesh_.size(), 0);
}

std::uint32_t LocalMesh::add_point(const Vec3& p) {
  mesh_.points.push_back(p);
  vert_to_tet_.push_back(kNone);
  return static_cast<std::uint32_t>(mesh_.points.size() - 1);
}

void LocalMesh::tidy(std::uint32_t first) {
  compact(mesh_);
  editor_.forget_dead();
  if (mesh_.points.size() == first) return;
  std::vector<std::uint32_t> to_new(mesh_.points.size() - first, kNone);
  for (const std::uint32_t v : mesh_.to_vert) {
    if (v >= first) to_new[v - first] = 0;
  }
  std::uint32_t count = first;
  for (std::uint32_t v = first; v < mesh_.points.size(); ++v) {
    if (to_new[v - first] == kNone) continue;
    mesh_.points[count] = mesh_.points[v];
    to_new[v - first] = count++;
  }
  mesh_.points.resize(count);
  for (std::uint32_t& v : mesh_.to_vert) {
    if (v >= first) v = to_new[v - first];
  }
}

}  // namespace tetloom::tets
