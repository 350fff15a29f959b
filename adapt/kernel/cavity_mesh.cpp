#include "adapt/kernel/cavity_mesh.hpp"

#include <algorithm>

#include "adapt/kernel/quality_pairs.hpp"
#include "core/predicates/predicates.hpp"

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
    for (const FaceCode side : {face, mesh.behind(face)}) {
      if (!side.valid()) continue;
      const std::uint32_t tet = side.tet();
      if (corner_of(tet, p) == 4) continue;
      for (std::uint32_t k = 0; k < cavity.core_size; ++k) {
        const FaceCode outer(tet, cavity.corners[slot_[tet]][k]);
        if (mesh.is_fixed(outer) || !mesh.behind(outer).valid()) return false;
      }
    }
  }
  return true;
}

// The pieces of model edges that a triangle's corner, a core of one, has in it; their other ends and edges go to
// `ends`.
void CavityMesh::take_pieces(const Triangle& corners, std::uint32_t core, std::vector<ModelEdgeEnd>& ends) {
  for (const std::uint32_t v : corners) {
    if (v == core) continue;
    const std::uint32_t edge = surface.find_edge(core, v);
    if (edge == kNone) continue;
    surface.remove_edge(core, v);
    ends.emplace_back(v, edge);
  }
}

void CavityMesh::change_surface(const Cavity& cavity, std::uint32_t p) {
  std::vector<SurfaceTriangle> made;
  std::vector<ModelEdgeEnd> ends;
  for (const FaceCode face : cavity.surface) {
    const auto corners = tets::verts_of(mesh, face);
    const SurfaceTriangle* found = surface.find(corners);
    if (!found) continue;  // a side of the part
    const SurfaceTriangle old = *found;
    if (cavity.core_size == 1) take_pieces(corners, cavity.core[0], ends);
    surface.remove(corners);
    if (std::find(corners.begin(), corners.end(), p) != corners.end()) continue;
    for (std::uint32_t k = 0; k < cavity.core_size; ++k) {
      SurfaceTriangle triangle = old;
      std::replace(triangle.verts.begin(), triangle.verts.end(), cavity.core[k], p);
      made.push_back(triangle);
    }
  }
  for (const SurfaceTriangle& triangle : made) surface.add(triangle);
  for (const auto& [v, edge] : ends)
    if (v != p) surface.add_edge(p, v, edge);
  if (cavity.core_size == 2) split_piece(cavity.core, p);
}

void CavityMesh::split_piece(const std::array<std::uint32_t, 4>& ends, std::uint32_t p) {
  const std::uint32_t edge = surface.find_edge(ends[0], ends[1]);
  if (edge == kNone) return;
  surface.remove_edge(ends[0], ends[1]);
  surface.add_edge(ends[0], p, edge);
  surface.add_edge(ends[1], p, edge);
}

// What a cavity's tets were, before others are written in their places.
void CavityMesh::remember(const Cavity& cavity, std::uint32_t p) {
  star_.resize(cavity.tets.size());
  old_.clear(), vanishing_.clear();
  for (std::size_t i = 0; i < cavity.tets.size(); ++i) {
    const std::uint32_t tet = cavity.tets[i];
    OldTet& old = star_[i];
    std::copy_n(&mesh.behind({tet, 0}), 4, old.behind.begin());
    old.fixed = mesh.to_fixed[tet];
    old.apex = corner_of(tet, p);
    (old.vanishes() ? vanishing_ : old_).push_back(tet);
  }
}

// The tets of the star of p have their places, without links: the first of each tet that stays its own, further ones
// those of tets that vanish, then others.
void CavityMesh::write_star(const Cavity& cavity, std::uint32_t p, const MadeQualities& qualities) {
  const std::size_t size = cavity.core_size, staying = old_.size(), more = size - 1;
  old_.insert(old_.end(), vanishing_.begin(), vanishing_.end());
  made_.resize(staying * size), regions_.resize(staying * size);
  std::size_t first = 0;
  const auto place = [&](std::size_t k) { return k == 0 ? first : staying + first * more + k - 1; };
  for (std::size_t i = 0; i < star_.size(); ++i) {
    if (star_[i].vanishes()) continue;
    const std::uint32_t *v = verts(cavity.tets[i]), region = mesh.to_region[cavity.tets[i]];
    for (std::size_t k = 0; k < size; ++k) {
      tets::NewTet& made = made_[place(k)];
      made = {{v[0], v[1], v[2], v[3]}, double{qualities[i * size + k]}};
      made.verts[cavity.corners[i][k]] = p;
      regions_[place(k)] = region;
    }
    ++first;
  }
  const auto ids = editor_.write(mesh, &to_quality, {old_, made_, regions_});
  first = 0;
  for (OldTet& old : star_) {
    if (old.vanishes()) continue;
    for (std::size_t k = 0; k < size; ++k) note_made(old.ids[k] = ids[place(k)]);
    ++first;
  }
}

// Of a tet that vanishes: a triangle behind which nothing lies passes to what was behind the tet.
void CavityMesh::pass_triangle(const Cavity& cavity, std::size_t i) {
  if (star_[i].behind[star_[i].apex].valid()) return;
  for (std::uint32_t k = 0; k < cavity.core_size; ++k) {
    const FaceCode outer = star_[i].behind[cavity.corners[i][k]];
    tets::link_sides(mesh, outer, {}, true);
    for (const std::uint32_t v : tets::verts_of(mesh, outer)) vert_to_tet[v] = outer.tet();
  }
}

// Links what has taken the place of the i-th tet, with p in that of the k-th vertex of the core.
void CavityMesh::link_made(const Cavity& cavity, std::size_t i, std::uint32_t k) {
  const OldTet& old = star_[i];
  const std::uint32_t made = old.ids[k], own = cavity.corners[i][k];
  tets::link_sides(mesh, {made, own}, old.behind[own], old.is_fixed(own));
  unsigned in_core = 1u << own;
  for (std::uint32_t other = 0; other < cavity.core_size; ++other) {
    if (other == k) continue;
    const std::uint32_t corner = cavity.corners[i][other];
    mesh.behind({made, corner}) = {old.ids[other], own};
    in_core |= 1u << corner;
  }
  for (std::uint32_t j = 0; j < 4; ++j) {
    if (in_core >> j & 1) continue;
    const FaceCode behind = old.behind[j];
    if (!behind.valid()) {
      tets::link_sides(mesh, {made, j}, {}, old.is_fixed(j));
      continue;
    }
    const std::size_t slot = slot_[behind.tet()];
    const OldTet& beside = star_[slot];
    if (!beside.vanishes()) {
      mesh.behind({made, j}) = behind.of_tet(beside.ids[k]);
      if (old.is_fixed(j)) tets::fix_side(mesh, {made, j});
    } else {
      const std::uint32_t outer = cavity.corners[slot][k];
      tets::link_sides(mesh, {made, j}, beside.behind[outer], old.is_fixed(j) || beside.is_fixed(outer));
    }
  }
}

void CavityMesh::reconnect(const Cavity& cavity, std::uint32_t p, const MadeQualities& qualities) {
  stamp(cavity);
  if (!cavity.surface.empty()) change_surface(cavity, p);
  remember(cavity, p);
  write_star(cavity, p, qualities);
  for (std::size_t i = 0; i < star_.size(); ++i) {
    if (star_[i].vanishes()) pass_triangle(cavity, i);
    for (std::uint32_t k = 0; k < cavity.core_size && !star_[i].vanishes(); ++k) link_made(cavity, i, k);
  }
  if (cavity.core_size == 1 && cavity.core[0] != p) vert_to_tet[cavity.core[0]] = kNone;
}

void CavityMesh::replace(std::span<const std::uint32_t> old, std::span<const tets::NewTet> made) {
  for (const std::uint32_t tet : editor_.replace(mesh, &to_quality, {old, made})) note_made(tet);
}

void CavityMesh::note_made(std::uint32_t tet) {
  for (int j = 0; j < 4; ++j) vert_to_tet[verts(tet)[j]] = tet;
  mark_changed(tet);
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
  made_.clear();
  for (const tets::RingTriangle& triangle : triangles)
    for (const auto& v : tets::tets_over(ring, triangle)) made_.push_back({v, quality_of(v[0], v[1], v[2], v[3])});
  replace(ring.old(), made_);
}

std::uint32_t CavityMesh::add_vertex(const Vec3& x, const Tensor& metric, PackedEntity entity, BackgroundTet hint) {
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

}  // namespace tetloom::adapt
