// Finds the tets of a cavity. Branches on what lies where cannot be predicted, so there are hardly any.
#include <algorithm>

#include "adapt/kernel/cavity_mesh.hpp"

namespace tetloom::adapt {

namespace {

// Of a tet's vertices, the corner that is `vert`. Pre: one is. Without a branch.
std::uint32_t corner_with(const std::uint32_t* verts, std::uint32_t vert) {
  return (verts[1] == vert) + 2u * (verts[2] == vert) + 3u * (verts[3] == vert);
}

}  // namespace

std::array<std::uint32_t, 2> CavityMesh::beside_edge(const Cavity& shell, std::size_t i) const {
  const auto& [first, second] = tets::kOtherCorners[shell.corners[i][0]][shell.corners[i][1]];
  const std::uint32_t* v = verts(shell.tets[i]);
  return {v[first], v[second]};
}

void CavityMesh::add_to(Cavity& cavity, std::uint32_t tet, const std::array<std::uint8_t, 4>& corners) const {
  cavity.tets.push_back(tet);
  cavity.corners.push_back(corners);
  cavity.least = std::min(cavity.least, double{to_quality[tet]});
}

void CavityMesh::start_cavity(std::span<const std::uint32_t> core, Cavity& cavity) const {
  cavity.core_size = static_cast<std::uint32_t>(core.size());
  std::copy(core.begin(), core.end(), cavity.core.begin());
  cavity.tets.clear(), cavity.corners.clear(), cavity.surface.clear();
  cavity.least = kDeadQuality;
  if (slot_.size() < mesh.size()) slot_.resize(std::max(mesh.size(), slot_.size() + slot_.size() / 8), 0);
}

bool CavityMesh::collect(std::span<const std::uint32_t> core, std::uint32_t tet, Cavity& cavity) const {
  start_cavity(core, cavity);
  return core.size() == 1   ? collect_ball(tet, cavity)
         : core.size() == 2 ? collect_shell(tet, Cavity::kMostTets, -1, cavity)
                            : collect_few(tet, cavity);
}

bool CavityMesh::collect_around_worst(const std::array<std::uint32_t, 2>& edge, std::uint32_t tet, std::size_t most,
                                      Cavity& cavity) const {
  start_cavity(edge, cavity);
  return collect_shell(tet, most, double{to_quality[tet]}, cavity);
}

bool CavityMesh::collect_ball(std::uint32_t tet, Cavity& cavity) const {
  const std::uint32_t core = cavity.core[0];
  std::uint32_t* const list = cavity.tets.data();
  std::uint32_t* const slot = slot_.data();
  std::array<std::uint8_t, 4>* const corners = cavity.corners.data();
  const std::uint32_t* const all_verts = mesh.to_vert.data();
  const FaceCode* const to_neighbor = mesh.to_neighbor.data();
  std::array<std::uint8_t, CavityList<std::uint32_t>::kRoom> entries;  // faces through which tets were found
  std::uint32_t size = 1;
  float least = kDeadQuality;
  list[0] = tet, slot[tet] = 0, entries[0] = 4;
  for (std::uint32_t i = 0; i < size; ++i) {
    if (size > Cavity::kMostTets) return false;
    const std::uint32_t here = list[i];
    const std::uint32_t* v = all_verts + std::size_t{here} * 4;
    const auto own = static_cast<std::uint8_t>(corner_with(v, core));
    corners[i] = {own};
    least = std::min(least, to_quality[here]);
    if ((mesh.to_fixed[here] & ~(1u << own)) != 0) add_fixed_faces(here, own, cavity);
    const auto& faces = tets::kFaceVerts[own];
    for (std::size_t k = 0; k < 3; ++k) {
      const FaceCode behind = mesh.behind({here, faces[k]});
      if (faces[k] == entries[i] || !behind.valid()) continue;
      const std::uint32_t next = behind.tet(), before = slot[next];
      const bool is_known = (before < size) & (list[std::min(before, size)] == next);
      list[size] = next, entries[size] = behind.side();
      slot[next] = is_known ? before : size;
      size += !is_known;
      __builtin_prefetch(all_verts + std::size_t{next} * 4);
      __builtin_prefetch(to_neighbor + std::size_t{next} * 4);
    }
  }
  cavity.tets.set_size(size), cavity.corners.set_size(size);
  cavity.least = double{least};
  return true;
}

// Those that have a core of one, of a tet that has it as its corner `own`.
void CavityMesh::add_fixed_faces(std::uint32_t tet, std::uint32_t own, Cavity& cavity) const {
  for (std::uint32_t j = 0; j < 4; ++j) {
    const FaceCode face(tet, j), behind = mesh.behind(face);
    if (j != own && mesh.is_fixed(face) && (!behind.valid() || face < behind)) cavity.surface.push_back(face);
  }
}

// Turns around the edge, and from the start the other way round where something lies at it.
bool CavityMesh::collect_shell(std::uint32_t tet, std::size_t most, double least, Cavity& cavity) const {
  const std::uint32_t a = cavity.core[0], b = cavity.core[1];
  const std::uint32_t* const all_verts = mesh.to_vert.data();
  const FaceCode* const to_neighbor = mesh.to_neighbor.data();
  const auto add = [&](std::uint32_t next) {
    const std::uint32_t* v = all_verts + std::size_t{next} * 4;
    const std::uint32_t i = corner_with(v, a), j = corner_with(v, b);
    add_to(cavity, next, {static_cast<std::uint8_t>(i), static_cast<std::uint8_t>(j)});
    return i + j;
  };
  add(tet);
  const auto& [first, second] = tets::kOtherCorners[cavity.corners[0][0]][cavity.corners[0][1]];
  for (const auto& [from, beside] : {std::pair(first, second), std::pair(second, first)}) {
    std::uint32_t here = tet, leaving = from, staying = beside;
    for (;;) {
      const FaceCode face(here, leaving), behind = mesh.behind(face);
      if (mesh.is_fixed(face)) cavity.surface.push_back(!behind.valid() ? face : std::min(face, behind));
      if (!behind.valid()) break;
      const std::uint32_t next = behind.tet();
      if (next == tet) return true;
      if (cavity.tets.size() == most || double{to_quality[next]} < least) return false;
      const std::uint32_t in_core = add(next);
      here = next;
      // Out through the face opposite to the vertex that both tets have beside the edge.
      staying = behind.side();
      leaving = 6 - in_core - staying;
    }
  }
  return true;
}

bool CavityMesh::collect_few(std::uint32_t tet, Cavity& cavity) const {
  const auto corners_in = [&](std::uint32_t t) {
    std::array<std::uint8_t, 4> corners{4, 4, 4, 4};
    for (std::uint32_t k = 0; k < cavity.core_size; ++k)
      corners[k] = static_cast<std::uint8_t>(corner_of(t, cavity.core[k]));
    return corners;
  };
  add_to(cavity, tet, corners_in(tet));
  if (cavity.core_size == 4) return true;
  for (std::uint32_t j = 0; j < 4; ++j) {
    if (cavity.is_core(verts(tet)[j])) continue;
    const FaceCode face(tet, j), behind = mesh.behind(face);
    if (mesh.is_fixed(face)) cavity.surface.push_back(!behind.valid() ? face : std::min(face, behind));
    if (behind.valid()) add_to(cavity, behind.tet(), corners_in(behind.tet()));
  }
  return true;
}

bool CavityMesh::find_ring(const Cavity& shell, tets::EdgeRing& ring) const {
  const std::size_t count = shell.tets.size();
  if (count > tets::kMostRingVerts) return false;
  // The lower of the first tet's other two corners was left behind the tet: the ring goes from there to the higher one.
  const std::uint32_t a = shell.corners[0][0], b = shell.corners[0][1];
  const auto& [first, second] = tets::kOtherCorners[a][b];
  const bool even = tets::kIsEven[a][b];
  ring.a = shell.core[even ? 0 : 1], ring.b = shell.core[even ? 1 : 0];
  const std::uint32_t* v = verts(shell.tets[0]);
  ring.verts[0] = v[first], ring.verts[1] = v[second];
  ring.count = static_cast<int>(count);
  std::copy(shell.tets.begin(), shell.tets.end(), ring.tets.begin());
  for (std::size_t i = 1; i + 1 < count; ++i) {
    const auto [p, q] = beside_edge(shell, i);
    ring.verts[i + 1] = p == ring.verts[i] ? q : p;
  }
  return true;
}

}  // namespace tetloom::adapt
