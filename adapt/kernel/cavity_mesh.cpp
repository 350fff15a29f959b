#include "adapt/kernel/cavity_mesh.hpp"

#include <algorithm>

#include "adapt/kernel/quality_pairs.hpp"
#include "core/predicates/predicates.hpp"
#include "tetloom/assert.hpp"

namespace tetloom::adapt {

namespace {

using tets::pairs::Pair;
using tets::pairs::pair_of;
using tets::pairs::PairVec;

}  // namespace

double CavityMesh::quality_of(std::uint32_t a, std::uint32_t b, std::uint32_t c, std::uint32_t d) const {
  const double quality = cubed_mean_ratio(mesh.points, to_metric, {a, b, c, d});
  const bool is_sure = quality > surely_positive_ || !(quality > 0);
  return is_sure || orient3d(point(a), point(b), point(c), point(d)) > 0 ? quality : 0;
}

double CavityMesh::length_of(std::uint32_t a, std::uint32_t b) const {
  return edge_length(to_metric[a].tensor, to_metric[b].tensor, point(b) - point(a));
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
  double least = kDeadQuality;
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
  return least > surely_positive_ || makes_positive(cavity, p) ? least : 0;
}

// Exactly.
bool CavityMesh::makes_positive(const Cavity& cavity, std::uint32_t p) const {
  const bool is_core = cavity.is_core(p);
  for (std::size_t i = 0; i < cavity.tets.size(); ++i) {
    const std::uint32_t* old = verts(cavity.tets[i]);
    if (!is_core && corner_of(cavity.tets[i], p) < 4) continue;
    for (std::uint32_t k = 0; k < cavity.core_size; ++k) {
      const auto& [a, b, c] = tets::kFaceVerts[cavity.corners[i][k]];
      if (orient3d(point(p), point(old[a]), point(old[b]), point(old[c])) <= 0) return false;
    }
  }
  return true;
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
  double least = kDeadQuality;
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
  return least > surely_positive_ || makes_positive(cavity, p) ? least : 0;
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
  const auto link = [&](FaceCode face, FaceCode behind, bool fixed) {
    tets::link_sides(mesh, face, behind);
    if (fixed) {
      tets::fix_side(mesh, face);
      if (behind != kNone) tets::fix_side(mesh, behind);
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
          if (fixed) tets::fix_side(mesh, base + j);
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
  for (const VertexMetric& metric : to_metric) note_metric(metric);
  for (std::uint32_t tet = 0; tet < mesh.size(); ++tet) {
    const std::uint32_t* v = verts(tet);
    for (std::size_t j = 0; j < 4; ++j) vert_to_tet[v[j]] = tet;
    to_quality[tet] = static_cast<float>(quality_of(v[0], v[1], v[2], v[3]));
  }
}

void CavityMesh::replace_ring(const tets::EdgeRing& ring, std::span<const tets::RingTriangle> triangles) {
  const std::size_t count = 2 * triangles.size(), old = ring.old().size();
  const std::uint32_t region = mesh.to_region[ring.tets[0]];
  filling_.open(mesh, ring.old(), count);
  std::array<std::uint32_t, std::size_t{2} * tets::kMostRingVerts> places;
  for (std::size_t i = 0; i < count; ++i) places[i] = i < old ? ring.tets[i] : take_tet();
  for (std::size_t i = count; i < old; ++i) drop_tet(ring.tets[i]);
  const std::span<const std::uint32_t> ids = std::span(places).first(count);
  for (std::size_t t = 0; t < triangles.size(); ++t) {
    const auto [at_b, at_a] = tets::tets_over(ring, triangles[t]);
    std::copy(at_b.begin(), at_b.end(), &mesh.to_vert[std::size_t{ids[2 * t]} * 4]);
    std::copy(at_a.begin(), at_a.end(), &mesh.to_vert[std::size_t{ids[2 * t + 1]} * 4]);
  }
  for (const std::uint32_t tet : ids) mesh.to_region[tet] = region, mesh.to_fixed[tet] = 0;
  [[maybe_unused]] const bool fits = filling_.close(mesh, ids);
  TETLOOM_DEBUG_ASSERT(fits);
  refresh_qualities(ids);
  for (const std::uint32_t tet : ids) {
    for (int j = 0; j < 4; ++j) vert_to_tet[verts(tet)[j]] = tet;
    mark_changed(tet);
  }
}

std::uint32_t CavityMesh::take_tet() {
  const std::uint32_t tet = places_.take(mesh);
  if (tet == to_quality.size()) to_quality.push_back(kDeadQuality);
  return tet;
}

void CavityMesh::drop_tet(std::uint32_t tet) {
  places_.drop(mesh, tet);
  to_quality[tet] = kDeadQuality;
}

std::uint32_t CavityMesh::add_vertex(const Vec3& x, const Tensor& metric, PackedEntity entity, std::uint32_t hint) {
  mesh.points.push_back(x);
  to_metric.push_back({metric, det(metric)});
  note_metric(to_metric[to_metric.size() - 1]);
  to_entity.push_back(entity);
  vert_to_tet.push_back(kNone);
  to_hint.push_back(hint);
  to_frozen.push_back(0);
  to_state.push_back(kChanged | kUnsettled);
  return static_cast<std::uint32_t>(mesh.points.size() - 1);
}

void CavityMesh::set_metric(std::uint32_t v, const Tensor& metric) {
  to_metric[v] = {metric, det(metric)};
  note_metric(to_metric[v]);
}

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
