#include "adapt/kernel/cavity_mesh.hpp"

#include <algorithm>

#include "mesher/tets/tet_pairs.hpp"

namespace tetloom::adapt {

namespace {

using tets::pairs::Pair;
using tets::pairs::pair_of;
using tets::pairs::PairVec;

constexpr float kDead = 2;

// The cubed mean ratios of two tets with edges p, q, r, each in its metric.
Pair cubed_mean_ratio(const PairVec& p, const PairVec& q, const PairVec& r, const VertexMetric& one,
                      const VertexMetric& other) {
  const Tensor &m = one.tensor, &n = other.tensor;
  const Pair volume = dot(cross(p, q), r);
  const PairVec s = p + q + r;
  const auto sum = [&](Pair PairVec::*i, Pair PairVec::*j) {
    return 4 * (p.*i * p.*j + q.*i * q.*j + r.*i * r.*j) - s.*i * s.*j;
  };
  const Pair squares =
      Pair{m.xx, n.xx} * sum(&PairVec::x, &PairVec::x) + Pair{m.yy, n.yy} * sum(&PairVec::y, &PairVec::y) +
      Pair{m.zz, n.zz} * sum(&PairVec::z, &PairVec::z) +
      2 * (Pair{m.xy, n.xy} * sum(&PairVec::x, &PairVec::y) + Pair{m.xz, n.xz} * sum(&PairVec::x, &PairVec::z) +
           Pair{m.yz, n.yz} * sum(&PairVec::y, &PairVec::z));
  const Pair quality = 432 * volume * volume * Pair{one.det, other.det} / (squares * squares * squares);
  return volume > 0 ? quality : Pair{};
}

// Of a tet's vertices, the corner that is `vert`. Pre: one is. Without a branch.
std::uint32_t corner_with(const std::uint32_t* verts, std::uint32_t vert) {
  return (verts[1] == vert) + 2u * (verts[2] == vert) + 3u * (verts[3] == vert);
}

// The lower of the two corners beside two others.
constexpr std::uint32_t kFirstBeside[4][4]{{4, 2, 1, 1}, {2, 4, 0, 0}, {1, 0, 4, 0}, {1, 0, 0, 4}};
// Whether two corners, the lower and the higher of those beside them are an even permutation.
constexpr bool kIsEven[4][4]{
    {false, true, false, true}, {false, false, true, false}, {true, false, false, true}, {false, true, false, false}};

}  // namespace

double CavityMesh::quality_of(std::uint32_t a, std::uint32_t b, std::uint32_t c, std::uint32_t d) const {
  return cubed_mean_ratio(mesh.points, to_metric, {a, b, c, d});
}

double CavityMesh::length_of(std::uint32_t a, std::uint32_t b) const {
  return edge_length(to_metric[a].tensor, to_metric[b].tensor, point(b) - point(a));
}

std::array<std::uint32_t, 2> CavityMesh::beside_edge(const Cavity& shell, std::size_t i) const {
  const std::uint32_t a = shell.corners[i][0], b = shell.corners[i][1], first = kFirstBeside[a][b];
  const std::uint32_t* v = verts(shell.tets[i]);
  return {v[first], v[6 - a - b - first]};
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
  cavity.least = kDead;
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

// Branches on what lies where cannot be predicted, so there are hardly any.
bool CavityMesh::collect_ball(std::uint32_t tet, Cavity& cavity) const {
  const std::uint32_t core = cavity.core[0];
  std::uint32_t* const list = cavity.tets.data();
  std::uint32_t* const slot = slot_.data();
  std::array<std::uint8_t, 4>* const corners = cavity.corners.data();
  const std::uint32_t* const all_verts = mesh.to_vert.data();
  const FaceCode* const to_neighbor = mesh.to_neighbor.data();
  std::array<std::uint8_t, CavityList<std::uint32_t>::kRoom> entries;  // faces through which tets were found
  std::uint32_t size = 1;
  float least = kDead;
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
      const FaceCode behind = to_neighbor[std::size_t{here} * 4 + faces[k]];
      if (faces[k] == entries[i] || behind == kNone) continue;
      const std::uint32_t next = behind / 4, before = slot[next];
      const bool is_known = (before < size) & (list[std::min(before, size)] == next);
      list[size] = next, entries[size] = behind % 4;
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
    const FaceCode face = tet * 4 + j, behind = mesh.to_neighbor[face];
    if (j != own && mesh.is_fixed(face) && (behind == kNone || face < behind)) cavity.surface.push_back(face);
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
  const std::uint32_t sum = add(tet);
  // The corners beside those of the edge.
  const std::uint32_t first = kFirstBeside[cavity.corners[0][0]][cavity.corners[0][1]], second = 6 - sum - first;
  for (const auto& [from, beside] : {std::pair(first, second), std::pair(second, first)}) {
    std::uint32_t here = tet, leaving = from, staying = beside;
    for (;;) {
      const FaceCode face = here * 4 + leaving, behind = to_neighbor[face];
      if (mesh.is_fixed(face)) cavity.surface.push_back(behind == kNone ? face : std::min(face, behind));
      if (behind == kNone) break;
      const std::uint32_t next = behind / 4;
      if (next == tet) return true;
      if (cavity.tets.size() == most || double{to_quality[next]} < least) return false;
      const std::uint32_t in_core = add(next);
      here = next;
      // Out through the face opposite to the vertex that both tets have beside the edge.
      staying = behind % 4;
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
    const FaceCode face = tet * 4 + j, behind = mesh.to_neighbor[face];
    if (mesh.is_fixed(face)) cavity.surface.push_back(behind == kNone ? face : std::min(face, behind));
    if (behind != kNone) add_to(cavity, behind / 4, corners_in(behind / 4));
  }
  return true;
}

std::uint32_t CavityMesh::find_edge(std::uint32_t a, std::uint32_t b, Cavity& scratch) const {
  const std::uint32_t tet = vert_to_tet[a];
  if (tet == kNone) return kNone;
  if (corner_of(tet, b) < 4) return tet;
  if (!collect(std::span(&a, 1), tet, scratch)) return kNone;
  for (const std::uint32_t t : scratch.tets)
    if (corner_of(t, b) < 4) return t;
  return kNone;
}

double CavityMesh::evaluate(const Cavity& cavity, std::uint32_t p, double goal, MadeQualities& made) const {
  double least = kDead;
  const std::uint32_t size = cavity.core_size;
  made.resize(cavity.tets.size() * size);
  const bool is_core = cavity.is_core(p);
  const Vec3 x = point(p);
  const VertexMetric& metric = to_metric[p];
  float* out = made.data();
  for (std::size_t i = 0; i < cavity.tets.size(); ++i, out += size) {
    const std::uint32_t* old = verts(cavity.tets[i]);
    if (!is_core && (old[0] == p || old[1] == p || old[2] == p || old[3] == p)) continue;
    for (std::uint32_t k = 0; k < size; ++k) {
      const auto& face = tets::kFaceVerts[cavity.corners[i][k]];
      const std::array<std::uint32_t, 3> base{old[face[0]], old[face[1]], old[face[2]]};
      const VertexMetric* most = &metric;
      for (const std::uint32_t v : base)
        if (to_metric[v].det > most->det) most = &to_metric[v];
      const double quality = cubed_mean_ratio(point(base[0]) - x, point(base[1]) - x, point(base[2]) - x, *most);
      out[k] = static_cast<float>(quality);
      least = std::min(least, quality);
      if (!(least > goal)) return least;
    }
  }
  return least;
}

// Two tets at a time.
double CavityMesh::evaluate_all(const Cavity& cavity, std::uint32_t p, double goal, MadeQualities& made) const {
  struct Made {
    std::array<const Vec3*, 3> base;
    const VertexMetric* metric;
  };
  const std::size_t core = cavity.core_size, count = cavity.tets.size() * core;
  made.resize(count);
  const auto at = [&](std::size_t n) {
    const std::uint32_t* old = verts(cavity.tets[n / core]);
    const auto& [a, b, c] = tets::kFaceVerts[cavity.corners[n / core][n % core]];
    const VertexMetric* metric = &to_metric[p];
    for (const std::uint32_t v : {old[a], old[b], old[c]})
      if (to_metric[v].det > metric->det) metric = &to_metric[v];
    return Made{{&point(old[a]), &point(old[b]), &point(old[c])}, metric};
  };
  const PairVec x = pair_of(point(p));
  double least = kDead;
  for (std::size_t n = 0; n < count; n += 2) {
    const std::size_t m = std::min(n + 1, count - 1);
    const Made one = at(n), other = at(m);
    const Pair qualities =
        cubed_mean_ratio(pair_of(*one.base[0], *other.base[0]) - x, pair_of(*one.base[1], *other.base[1]) - x,
                         pair_of(*one.base[2], *other.base[2]) - x, *one.metric, *other.metric);
    made[m] = static_cast<float>(qualities[1]), made[n] = static_cast<float>(qualities[0]);
    least = std::min(least, std::min(qualities[0], qualities[1]));
    if (!(least > goal)) return least;
  }
  return least;
}

void CavityMesh::stamp(const Cavity& cavity) const {
  for (std::uint32_t i = 0; i < cavity.tets.size(); ++i) slot_[cavity.tets[i]] = i;
}

bool CavityMesh::is_sound(const Cavity& cavity, std::uint32_t p) const {
  stamp(cavity);
  // A triangle must not come to lie on another one.
  for (const FaceCode face : cavity.surface) {
    const auto corners = tets::verts_of(mesh, face);
    if (std::find(corners.begin(), corners.end(), p) != corners.end()) continue;
    for (std::uint32_t k = 0; k < cavity.core_size; ++k) {
      Triangle verts = corners;
      std::replace(verts.begin(), verts.end(), cavity.core[k], p);
      if (surface.find(verts)) return false;
    }
    // Nothing but a triangle where a tet vanishes: there must be a tet to have it.
    for (const FaceCode side : {face, mesh.to_neighbor[face]}) {
      if (side == kNone) continue;
      const std::uint32_t tet = side / 4;
      if (corner_of(tet, p) == 4) continue;
      for (std::uint32_t k = 0; k < cavity.core_size; ++k) {
        const FaceCode outer = tet * 4 + cavity.corners[slot_[tet]][k];
        if (mesh.is_fixed(outer) || mesh.to_neighbor[outer] == kNone) return false;
      }
    }
  }
  return true;
}

void CavityMesh::change_surface(const Cavity& cavity, std::uint32_t p) {
  std::vector<SurfaceTriangle> made;
  std::vector<std::pair<std::uint32_t, std::uint32_t>> ends;  // of model edges at a core of one
  for (const FaceCode face : cavity.surface) {
    const auto corners = tets::verts_of(mesh, face);
    const SurfaceTriangle* found = surface.find(corners);
    if (!found) continue;  // a side of the part
    const SurfaceTriangle old = *found;
    if (cavity.core_size == 1) {
      for (const std::uint32_t v : corners) {
        if (v == cavity.core[0]) continue;
        const std::uint32_t edge = surface.find_edge(cavity.core[0], v);
        if (edge == kNone) continue;
        surface.remove_edge(cavity.core[0], v);
        if (v != p) ends.emplace_back(v, edge);
      }
    }
    surface.remove(corners);
    if (std::find(corners.begin(), corners.end(), p) != corners.end()) continue;
    for (std::uint32_t k = 0; k < cavity.core_size; ++k) {
      SurfaceTriangle triangle = old;
      std::replace(triangle.verts.begin(), triangle.verts.end(), cavity.core[k], p);
      made.push_back(triangle);
    }
  }
  for (const SurfaceTriangle& triangle : made) surface.add(triangle);
  for (const auto& [v, edge] : ends) surface.add_edge(p, v, edge);
  if (cavity.core_size != 2) return;
  const std::uint32_t edge = surface.find_edge(cavity.core[0], cavity.core[1]);
  if (edge == kNone) return;
  surface.remove_edge(cavity.core[0], cavity.core[1]);
  surface.add_edge(cavity.core[0], p, edge);
  surface.add_edge(cavity.core[1], p, edge);
}

void CavityMesh::reconnect(const Cavity& cavity, std::uint32_t p, const MadeQualities& made) {
  const std::size_t count = cavity.tets.size();
  const std::uint32_t size = cavity.core_size;
  stamp(cavity);
  if (!cavity.surface.empty()) change_surface(cavity, p);
  old_verts_.resize(count), old_behind_.resize(count), ids_.resize(count), old_fixed_.resize(count);
  for (std::size_t i = 0; i < count; ++i) {
    const std::size_t tet = cavity.tets[i];
    for (std::size_t j = 0; j < 4; ++j) {
      old_verts_[i][j] = mesh.to_vert[tet * 4 + j];
      old_behind_[i][j] = mesh.to_neighbor[tet * 4 + j];
    }
    old_fixed_[i] = mesh.to_fixed[tet];
  }
  const auto corner_in = [&](std::size_t i, std::uint32_t v) {
    const auto& verts = old_verts_[i];
    return verts[0] == v ? 0u : verts[1] == v ? 1u : verts[2] == v ? 2u : verts[3] == v ? 3u : 4u;
  };
  // Those that stay take the places of their tets, further ones those of tets that vanish, then new places.
  std::vector<std::uint32_t>& free = free_;
  free.clear();
  for (std::size_t i = 0; i < count; ++i) {
    if (corner_in(i, p) < 4) {
      free.push_back(cavity.tets[i]);
      ids_[i][0] = kNone;
    }
  }
  std::size_t next_free = 0;
  for (std::size_t i = 0; i < count; ++i) {
    if (corner_in(i, p) < 4) continue;
    ids_[i][0] = cavity.tets[i];
    for (std::uint32_t k = 1; k < size; ++k) ids_[i][k] = next_free < free.size() ? free[next_free++] : take_tet();
  }
  const auto set_fixed = [&](FaceCode face) { mesh.to_fixed[face / 4] |= static_cast<std::uint8_t>(1u << face % 4); };
  const auto link = [&](FaceCode face, FaceCode behind, bool fixed) {
    mesh.to_neighbor[face] = behind;
    if (behind != kNone) mesh.to_neighbor[behind] = face;
    if (fixed) {
      set_fixed(face);
      if (behind != kNone) set_fixed(behind);
    }
  };
  for (std::size_t i = 0; i < count; ++i) {
    if (ids_[i][0] == kNone) continue;
    for (std::uint32_t k = 0; k < size; ++k) {
      const std::uint32_t tet = ids_[i][k];
      for (std::size_t j = 0; j < 4; ++j) mesh.to_vert[std::size_t{tet} * 4 + j] = old_verts_[i][j];
      mesh.to_vert[std::size_t{tet} * 4 + cavity.corners[i][k]] = p;
      mesh.to_region[tet] = mesh.to_region[cavity.tets[i]];
      mesh.to_fixed[tet] = 0;
      to_quality[tet] = made[i * size + k];
      for (std::size_t j = 0; j < 4; ++j) {
        const std::uint32_t v = mesh.to_vert[std::size_t{tet} * 4 + j];
        vert_to_tet[v] = tet, to_state[v] |= kChanged | kUnsettled;
      }
    }
  }
  for (std::size_t i = 0; i < count; ++i) {
    const bool vanishes = ids_[i][0] == kNone;
    unsigned in_core = 0;
    for (std::uint32_t k = 0; k < size; ++k) in_core |= 1u << cavity.corners[i][k];
    if (vanishes) {
      // A triangle behind which nothing lies passes to what was behind the tet.
      const std::uint32_t apex = corner_in(i, p);
      if (old_behind_[i][apex] == kNone) {
        for (std::uint32_t k = 0; k < size; ++k) {
          const FaceCode outer = old_behind_[i][cavity.corners[i][k]];
          link(outer, kNone, true);
          for (const std::uint8_t c : tets::kFaceVerts[outer % 4]) vert_to_tet[verts(outer / 4)[c]] = outer / 4;
        }
      }
      continue;
    }
    for (std::uint32_t k = 0; k < size; ++k) {
      const std::uint32_t base = ids_[i][k] * 4, own = cavity.corners[i][k];
      link(base + own, old_behind_[i][own], (old_fixed_[i] >> own & 1) != 0);
      for (std::uint32_t other = 0; other < size; ++other)
        if (other != k) mesh.to_neighbor[base + cavity.corners[i][other]] = ids_[i][other] * 4 + own;
      for (std::uint32_t j = 0; j < 4; ++j) {
        if (in_core >> j & 1) continue;
        const bool fixed = (old_fixed_[i] >> j & 1) != 0;
        const FaceCode behind = old_behind_[i][j];
        if (behind == kNone) {
          link(base + j, kNone, fixed);
          continue;
        }
        const std::uint32_t slot = slot_[behind / 4];
        if (ids_[slot][0] != kNone) {
          mesh.to_neighbor[base + j] = ids_[slot][k] * 4 + behind % 4;
          if (fixed) set_fixed(base + j);
          continue;
        }
        const std::uint32_t outer = cavity.corners[slot][k];
        link(base + j, old_behind_[slot][outer], fixed || (old_fixed_[slot] >> outer & 1) != 0);
      }
    }
  }
  for (; next_free < free.size(); ++next_free) drop_tet(free[next_free]);
  if (size == 1 && cavity.core[0] != p) vert_to_tet[cavity.core[0]] = kNone;
}

void CavityMesh::start() {
  vert_to_tet.resize(mesh.points.size());
  to_quality.resize_for_overwrite(mesh.size());
  for (std::uint32_t tet = 0; tet < mesh.size(); ++tet) {
    const std::uint32_t* v = verts(tet);
    for (std::size_t j = 0; j < 4; ++j) vert_to_tet[v[j]] = tet;
    to_quality[tet] = static_cast<float>(quality_of(v[0], v[1], v[2], v[3]));
  }
}

bool CavityMesh::find_ring(const Cavity& shell, tets::EdgeRing& ring) const {
  const std::size_t count = shell.tets.size();
  if (count > tets::kMostRingVerts) return false;
  // The lower of the first tet's other two corners was left behind the tet: the ring goes from there to the higher one.
  const std::uint32_t a = shell.corners[0][0], b = shell.corners[0][1], first = kFirstBeside[a][b];
  const bool even = kIsEven[a][b];
  ring.a = shell.core[even ? 0 : 1], ring.b = shell.core[even ? 1 : 0];
  const std::uint32_t* v = verts(shell.tets[0]);
  ring.verts[0] = v[first], ring.verts[1] = v[6 - a - b - first];
  ring.count = static_cast<int>(count);
  std::copy(shell.tets.begin(), shell.tets.end(), ring.tets.begin());
  for (std::size_t i = 1; i + 1 < count; ++i) {
    const auto [p, q] = beside_edge(shell, i);
    ring.verts[i + 1] = p == ring.verts[i] ? q : p;
  }
  return true;
}

void CavityMesh::replace_ring(const tets::EdgeRing& ring, std::span<const tets::RingTriangle> triangles) {
  const tets::RingFilling filling(mesh, ring);
  const std::size_t count = 2 * triangles.size(), old = ring.old().size();
  std::array<std::uint32_t, std::size_t{2} * tets::kMostRingVerts> ids;
  for (std::size_t i = 0; i < count; ++i) ids[i] = i < old ? ring.tets[i] : take_tet();
  for (std::size_t i = count; i < old; ++i) drop_tet(ring.tets[i]);
  filling.fill(mesh, triangles, std::span(ids).first(count));
  refresh_qualities(std::span(ids).first(count));
  for (const std::uint32_t tet : std::span(ids).first(count)) {
    for (int j = 0; j < 4; ++j) vert_to_tet[verts(tet)[j]] = tet;
    mark_changed(tet);
  }
}

RingInMetric::RingInMetric(const CavityMesh& mesh, const tets::EdgeRing& ring)
    : a_(mesh.point(ring.a)),
      b_(mesh.point(ring.b)),
      metric_of_a_(mesh.to_metric[ring.a]),
      metric_of_b_(mesh.to_metric[ring.b]) {
  for (std::size_t i = 0; i < ring.old().size(); ++i)
    points_[i] = &mesh.point(ring.verts[i]), metrics_[i] = &mesh.to_metric[ring.verts[i]];
}

double RingInMetric::worse_over(int i, int j, int k) const {
  const auto at = [](int place) { return static_cast<std::size_t>(place); };
  const Vec3 &p = *points_[at(i)], &q = *points_[at(j)], &r = *points_[at(k)];
  const VertexMetric* metric = metrics_[at(i)];
  for (const int other : {j, k})
    if (metrics_[at(other)]->det > metric->det) metric = metrics_[at(other)];
  const Vec3 pq = q - p, pr = r - p;
  const Pair qualities = cubed_mean_ratio(pair_of(pq, pr), pair_of(pr, pq), pair_of(b_ - p, a_ - p),
                                          metric_of_b_.det > metric->det ? metric_of_b_ : *metric,
                                          metric_of_a_.det > metric->det ? metric_of_a_ : *metric);
  return std::min(qualities[0], qualities[1]);
}

std::uint32_t CavityMesh::take_tet() {
  if (first_dead_ != kNone) {
    const std::uint32_t tet = first_dead_;
    first_dead_ = mesh.to_neighbor[std::size_t{tet} * 4];
    return tet;
  }
  const std::size_t tet = mesh.size();
  mesh.to_vert.resize_for_overwrite((tet + 1) * 4);
  mesh.to_neighbor.resize_for_overwrite((tet + 1) * 4);
  mesh.to_region.push_back(kNone);
  mesh.to_fixed.push_back(0);
  to_quality.push_back(kDead);
  return static_cast<std::uint32_t>(tet);
}

void CavityMesh::drop_tet(std::uint32_t tet) {
  mesh.to_vert[std::size_t{tet} * 4] = kNone;
  mesh.to_neighbor[std::size_t{tet} * 4] = first_dead_;
  mesh.to_fixed[tet] = 0;
  to_quality[tet] = kDead;
  first_dead_ = tet;
}

std::uint32_t CavityMesh::add_vertex(const Vec3& x, const Tensor& metric, PackedEntity entity, std::uint32_t hint) {
  mesh.points.push_back(x);
  to_metric.push_back({metric, det(metric)});
  to_entity.push_back(entity);
  vert_to_tet.push_back(kNone);
  to_hint.push_back(hint);
  to_frozen.push_back(0);
  to_state.push_back(kChanged | kUnsettled);
  return static_cast<std::uint32_t>(mesh.points.size() - 1);
}

void CavityMesh::set_metric(std::uint32_t v, const Tensor& metric) { to_metric[v] = {metric, det(metric)}; }

void CavityMesh::drop_last_vertex() {
  const std::size_t count = mesh.points.size() - 1;
  mesh.points.resize(count), to_metric.resize(count), to_entity.resize(count);
  vert_to_tet.resize(count), to_hint.resize(count), to_frozen.resize(count), to_state.resize(count);
}

void CavityMesh::refresh_qualities(std::span<const std::uint32_t> list) {
  for (const std::uint32_t tet : list) {
    const std::uint32_t* v = verts(tet);
    to_quality[tet] = static_cast<float>(quality_of(v[0], v[1], v[2], v[3]));
  }
}

}  // namespace tetloom::adapt
