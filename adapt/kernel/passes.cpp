#include "adapt/kernel/passes.hpp"

#include <algorithm>
#include <cmath>

#include "mesher/tets/newton_smoothing.hpp"

namespace tetloom::adapt {

namespace {

using tets::cube;

using tets::verts_of;

constexpr std::uint8_t kEdgeCorners[6][2]{{0, 1}, {0, 2}, {0, 3}, {1, 2}, {1, 3}, {2, 3}};
constexpr double kMoved = 0.1;  // in the metric: what is beside may then have another place
constexpr double kSplitLoss = 0.125, kLeastSplit = 0.03, kNoWorse = 0.99;
constexpr double kOnModel = 1e-6;  // of an edge: nearer than that is on the model
constexpr double kLeastLed = 0.02;
constexpr float kPoor = 0.03f;  // cubed quality: below, everything is tried again and again
constexpr double kGain = 1.0001;
constexpr double kFlat = 1 - 1e-10;

Vec3 normal_of(const CavityMesh& mesh, const Triangle& t) {
  return normalized(cross(mesh.point(t[1]) - mesh.point(t[0]), mesh.point(t[2]) - mesh.point(t[0])));
}

// M = transpose(U) U, so that U e is as long in space as e in the metric.
struct Root {
  double xx, xy, xz, yy, yz, zz;
  explicit Root(const Tensor& m) {
    xx = std::sqrt(m.xx), xy = m.xy / xx, xz = m.xz / xx;
    yy = std::sqrt(m.yy - xy * xy), yz = (m.yz - xy * xz) / yy;
    zz = std::sqrt(m.zz - xz * xz - yz * yz);
  }
  Vec3 apply(const Vec3& e) const { return {xx * e.x + xy * e.y + xz * e.z, yy * e.y + yz * e.z, zz * e.z}; }
  Vec3 solve(const Vec3& y) const {
    Vec3 e;
    e.z = y.z / zz, e.y = (y.y - yz * e.z) / yy, e.x = (y.x - xy * e.y - xz * e.z) / xx;
    return e;
  }
};

void count(Verdicts& verdicts, Verdict verdict) { ++verdicts[static_cast<std::size_t>(verdict)]; }

Tensor mean(const Tensor& a, const Tensor& b) { return 0.5 * (a + b); }

// Where on the way from a to b the length from a is `share` of the whole: sizes change geometrically on the way.
double place_of(double la, double lb, double share) {
  const double r = lb / la;
  if (!(std::abs(r - 1) > 1e-3)) return share;
  const double s = std::log1p(share * (r - 1)) / std::log(r);
  return std::isfinite(s) ? std::clamp(s, 0.1, 0.9) : share;
}

}  // namespace

PackedEntity Passes::entity_of_edge(std::uint32_t a, std::uint32_t b) const {
  if (cavity_.surface.empty()) return PackedEntity(ModelEntity(3, mesh_.mesh.to_region[cavity_.tets[0]]));
  const std::uint32_t edge = mesh_.surface.find_edge(a, b);
  if (edge != kNone) return PackedEntity(ModelEntity(1, edge));
  return PackedEntity(ModelEntity(2, mesh_.surface.find(verts_of(mesh_.mesh, cavity_.surface[0]))->face));
}

bool Passes::is_frozen(const Cavity& cavity) const {
  if (cavity.surface.empty()) return false;
  for (std::uint32_t k = 0; k < cavity.core_size; ++k)
    if (!mesh_.to_frozen[cavity.core[k]]) return false;
  return true;
}

// The larger of the two lengths that its ends give an edge, squared: not below the square of its length.
double Passes::bound_of(std::uint32_t a, std::uint32_t b) const {
  const Vec3 e = mesh_.point(b) - mesh_.point(a);
  return std::max(dot(mesh_.to_metric[a].tensor, e), dot(mesh_.to_metric[b].tensor, e));
}

// The longest edge of a tet among those longer than `least`; false where there is none.
bool Passes::longest_edge(std::uint32_t tet, float least, Edge& edge) const {
  const std::uint32_t* v = mesh_.verts(tet);
  edge = {kNone, kNone, least};
  for (const auto& [i, j] : kEdgeCorners) {
    const std::uint32_t a = std::min(v[i], v[j]), b = std::max(v[i], v[j]);
    if (bound_of(a, b) < edge.length * edge.length) continue;
    const auto length = static_cast<float>(mesh_.length_of(a, b));
    if (length > edge.length ||
        (length == edge.length && edge.a != kNone && std::pair(a, b) < std::pair(edge.a, edge.b)))
      edge = {a, b, length};
  }
  return edge.a != kNone;
}

Verdict Passes::split(std::uint32_t a, std::uint32_t b, std::uint32_t tet) {
  const std::array<std::uint32_t, 2> core{a, b};
  if (!mesh_.collect(core, tet, cavity_)) return Verdict::TooLarge;
  if (is_frozen(cavity_)) return Verdict::Frozen;
  const Vec3 e = mesh_.point(b) - mesh_.point(a);
  const double la = std::sqrt(dot(mesh_.to_metric[a].tensor, e)), lb = std::sqrt(dot(mesh_.to_metric[b].tensor, e));
  const double pieces = std::max(2.0, std::round(mesh_.length_of(a, b)));
  const double share = std::floor(pieces / 2) / pieces;
  const PackedEntity entity = entity_of_edge(a, b);
  const bool on_surface = !cavity_.surface.empty();
  // Tets far from the metric become worse before they become better, but not without an end.
  const double floor = std::max(std::min(cube(options_.floor), kSplitLoss * cavity_.least),
                                std::min(cube(kLeastSplit), kNoWorse * cavity_.least));
  const Vec3 on_edge = mesh_.point(a) + place_of(la, lb, share) * e;
  std::array<Vec3, 2> places{on_edge, on_edge};
  int first = 1;
  if (on_surface && project_) {
    const auto spot = project_(entity.unpack(), on_edge);
    if (spot && norm2(spot->point - on_edge) < 0.25 * norm2(e)) places[0] = spot->point, first = 0;
  }
  for (int i = first; i < 2; ++i) {
    std::uint32_t hint = mesh_.to_hint[a];
    const Tensor metric = source_.at(places[i], hint);
    const std::uint32_t p =
        mesh_.add_vertex(places[i], mean(mesh_.to_metric[a].tensor, mesh_.to_metric[b].tensor), entity, hint);
    const double least = mesh_.evaluate(cavity_, p, floor, made_);
    if (least > floor) {
      mesh_.set_metric(p, metric);
      mesh_.evaluate(cavity_, p, -1, made_);
      mesh_.reconnect(cavity_, p, made_);
      return Verdict::Done;
    }
    mesh_.drop_last_vertex();
  }
  return Verdict::Quality;
}

std::size_t Passes::split_edges(double longest) {
  std::size_t done = 0;
  const auto limit = static_cast<float>(longest);
  // Tets that are made on the way are visited as well.
  const auto size = static_cast<std::uint32_t>(mesh_.mesh.size());
  for (std::uint32_t tet = 0; tet < size; ++tet) {
    if (tet % 4096 == 0) runner_.check_cancelled();
    if (mesh_.mesh.is_dead(tet) || !mesh_.is_active(tet)) continue;
    for (int attempt = 0; attempt < 4 && !mesh_.mesh.is_dead(tet); ++attempt) {
      Edge edge{};
      if (!longest_edge(tet, limit, edge)) break;
      // Along the path of longest edges.
      std::uint32_t at = tet;
      for (int step = 0; step < 64; ++step) {
        const std::array<std::uint32_t, 2> core{edge.a, edge.b};
        if (!mesh_.collect(core, at, cavity_)) break;
        Edge longer = edge;
        for (const std::uint32_t other : cavity_.tets) {
          Edge candidate{};
          if (longest_edge(other, longer.length * 1.0001f, candidate)) longer = candidate, at = other;
        }
        if (longer.length == edge.length) break;
        edge = longer;
      }
      const Verdict verdict = split(edge.a, edge.b, at);
      count(counts_.splits, verdict);
      if (verdict != Verdict::Done) break;
      ++done;
    }
  }
  return done;
}

// As far as the model is concerned. Pre: cavity_ is the ball of a.
bool Passes::can_collapse(std::uint32_t a, std::uint32_t b) const {
  const int dim = mesh_.dim_of(a);
  if (dim == 3) return true;
  if (dim == 0) return false;
  if (dim == 1) {
    const std::uint32_t edge = mesh_.surface.find_edge(a, b);
    return edge != kNone && edge == mesh_.to_entity[a].unpack().index;
  }
  for (const FaceCode face : cavity_.surface) {
    const Triangle verts = verts_of(mesh_.mesh, face);
    if (std::find(verts.begin(), verts.end(), b) != verts.end()) return true;
  }
  return false;
}

// Whether the triangles that have the core would fold, or leave their plane where there is no model to follow.
bool Passes::is_flat_enough(const Cavity& cavity, std::uint32_t p) const {
  const double least = project_ ? 0.9 : kFlat;
  for (const FaceCode face : cavity.surface) {
    const Triangle old = verts_of(mesh_.mesh, face);
    if (std::find(old.begin(), old.end(), p) != old.end()) continue;
    const Vec3 normal = normal_of(mesh_, old);
    for (std::uint32_t k = 0; k < cavity.core_size; ++k) {
      Triangle made = old;
      std::replace(made.begin(), made.end(), cavity.core[k], p);
      if (!(dot(normal_of(mesh_, made), normal) > least)) return false;
    }
  }
  return true;
}

// Whether the triangles of the cavity lie in one plane for each model face.
bool Passes::lies_in_planes(const Cavity& cavity) const {
  for (std::size_t i = 0; i < cavity.surface.size(); ++i) {
    const SurfaceTriangle* one = mesh_.surface.find(verts_of(mesh_.mesh, cavity.surface[i]));
    for (std::size_t j = 0; j < i; ++j) {
      const SurfaceTriangle* other = mesh_.surface.find(verts_of(mesh_.mesh, cavity.surface[j]));
      if (one->face == other->face && !(dot(normal_of(mesh_, one->verts), normal_of(mesh_, other->verts)) > kFlat))
        return false;
    }
  }
  return true;
}

// Whether an edge from p would be on the surface twice. Pre: cavity_ is that of the core.
bool Passes::pinches(std::uint32_t p, std::uint32_t) {
  std::vector<std::uint32_t> near, beside;
  for (const FaceCode face : cavity_.surface) {
    const Triangle verts = verts_of(mesh_.mesh, face);
    const bool has_p = std::find(verts.begin(), verts.end(), p) != verts.end();
    for (const std::uint32_t v : verts)
      if (v != p && !cavity_.is_core(v)) (has_p ? beside : near).push_back(v);
  }
  std::erase_if(near, [&](std::uint32_t v) { return std::find(beside.begin(), beside.end(), v) != beside.end(); });
  if (!mesh_.collect(std::span(&p, 1), mesh_.vert_to_tet[p], scratch_)) return true;
  for (const FaceCode face : scratch_.surface) {
    const Triangle verts = verts_of(mesh_.mesh, face);
    if (std::any_of(verts.begin(), verts.end(), [&](std::uint32_t v) { return cavity_.is_core(v); })) continue;
    for (const std::uint32_t v : verts)
      if (v != p && std::find(near.begin(), near.end(), v) != near.end()) return true;
  }
  return false;
}

// Whether an edge from `to` to a vertex of the ball of `from` would be longer than `longest`. Pre: cavity_ is that
// ball.
bool Passes::makes_long_edge(std::uint32_t from, std::uint32_t to, double longest) {
  ++mark_;
  marks_.resize(std::max(marks_.size(), mesh_.mesh.points.size()), 0);
  marks_[from] = marks_[to] = mark_;
  for (const std::uint32_t tet : cavity_.tets) {
    const std::uint32_t* v = mesh_.verts(tet);
    for (int j = 0; j < 4; ++j) {
      if (marks_[v[j]] == mark_) continue;
      marks_[v[j]] = mark_;
      if (bound_of(v[j], to) > longest * longest && mesh_.length_of(v[j], to) > longest) return true;
    }
  }
  return false;
}

Verdict Passes::collapse(std::uint32_t a, std::uint32_t b, double longest) {
  Verdict verdict = Verdict::Classification;
  double best = 0;
  std::uint32_t target = kNone;
  for (const auto& [from, to] : {std::pair(a, b), std::pair(b, a)}) {
    if (mesh_.to_frozen[from]) {
      verdict = std::max(verdict, Verdict::Frozen);
      continue;
    }
    if (!mesh_.collect(std::span(&from, 1), mesh_.vert_to_tet[from], cavity_)) {
      verdict = std::max(verdict, Verdict::TooLarge);
      continue;
    }
    if (!can_collapse(from, to)) continue;
    if (makes_long_edge(from, to, longest)) {
      verdict = std::max(verdict, Verdict::Length);
      continue;
    }
    const double goal =
        std::max(best, std::max(cube(options_.floor), std::min(cavity_.least, cube(options_.collapsible))));
    const double least = mesh_.evaluate(cavity_, to, goal, made_);
    if (!(least > goal)) {
      verdict = std::max(verdict, Verdict::Quality);
      continue;
    }
    if (!cavity_.surface.empty() &&
        (!is_flat_enough(cavity_, to) || !mesh_.is_sound(cavity_, to) || pinches(to, from))) {
      verdict = std::max(verdict, Verdict::Surface);
      continue;
    }
    best = least, target = to;
  }
  if (target == kNone) return verdict;
  const std::uint32_t from = target == b ? a : b;
  mesh_.collect(std::span(&from, 1), mesh_.vert_to_tet[from], cavity_);
  mesh_.evaluate(cavity_, target, -1, made_);
  mesh_.reconnect(cavity_, target, made_);
  return Verdict::Done;
}

std::size_t Passes::collapse_edges(double shortest, double longest) {
  std::vector<Edge> edges;
  for (std::uint32_t tet = 0; tet < mesh_.mesh.size(); ++tet) {
    if (mesh_.mesh.is_dead(tet) || !mesh_.is_active(tet)) continue;
    const std::uint32_t* v = mesh_.verts(tet);
    for (const auto& [i, j] : kEdgeCorners) {
      const std::uint32_t a = std::min(v[i], v[j]), b = std::max(v[i], v[j]);
      const Vec3 e = mesh_.point(b) - mesh_.point(a);
      if (std::min(dot(mesh_.to_metric[a].tensor, e), dot(mesh_.to_metric[b].tensor, e)) >= shortest * shortest)
        continue;
      const double length = mesh_.length_of(a, b);
      if (length < shortest) edges.push_back({a, b, static_cast<float>(length)});
    }
  }
  const auto before = [](const Edge& p, const Edge& q) {
    return std::tuple(p.length, p.a, p.b) < std::tuple(q.length, q.a, q.b);
  };
  std::sort(edges.begin(), edges.end(), before);
  std::size_t done = 0;
  for (std::size_t i = 0; i < edges.size(); ++i) {
    if (i % 1024 == 0) runner_.check_cancelled();
    const auto& [a, b, length] = edges[i];
    if (i > 0 && edges[i - 1].a == a && edges[i - 1].b == b) continue;
    if (mesh_.vert_to_tet[a] == kNone || mesh_.vert_to_tet[b] == kNone) continue;
    if (mesh_.find_edge(a, b, scratch_) == kNone) continue;
    if (mesh_.length_of(a, b) >= shortest) continue;
    const Verdict verdict = collapse(a, b, longest);
    count(counts_.collapses, verdict);
    done += verdict == Verdict::Done;
  }
  return done;
}

Verdict Passes::swap_at(std::uint32_t tet) {
  double goal = std::max(double{mesh_.to_quality[tet]} * kGain, tets::kSurelyPositive);
  std::array<std::uint32_t, 3> core{};
  std::uint32_t core_size = 0, target = kNone;
  std::array<std::uint32_t, 4> v;
  std::copy_n(mesh_.verts(tet), 4, v.begin());
  for (const auto& [i, j] : kEdgeCorners) {
    const std::array<std::uint32_t, 2> edge{v[i], v[j]};
    if (!mesh_.collect(edge, tet, cavity_) || cavity_.tets.size() > 10) continue;
    if (cavity_.least < mesh_.to_quality[tet]) continue;
    std::array<std::uint32_t, 24> ring;
    std::size_t ring_size = 0;
    if (!cavity_.surface.empty()) {
      if (cavity_.surface.size() != 2 || is_frozen(cavity_) || mesh_.surface.find_edge(edge[0], edge[1]) != kNone)
        continue;
      const Triangle s = verts_of(mesh_.mesh, cavity_.surface[0]), t = verts_of(mesh_.mesh, cavity_.surface[1]);
      if (mesh_.surface.find(s)->face != mesh_.surface.find(t)->face) continue;
      for (const Triangle& triangle : {s, t})
        for (const std::uint32_t u : triangle)
          if (u != edge[0] && u != edge[1]) ring[ring_size++] = u;
    } else {
      for (const std::uint32_t t : cavity_.tets) {
        for (std::uint32_t k = 0; k < 4; ++k) {
          const std::uint32_t u = mesh_.verts(t)[k];
          if (u == edge[0] || u == edge[1]) continue;
          if (std::find(ring.begin(), ring.begin() + ring_size, u) == ring.begin() + ring_size) ring[ring_size++] = u;
        }
      }
    }
    for (std::size_t r = 0; r < ring_size; ++r) {
      const double least = mesh_.evaluate(cavity_, ring[r], goal, made_);
      if (!(least > goal)) continue;
      if (!cavity_.surface.empty() &&
          (!is_flat_enough(cavity_, ring[r]) || !mesh_.is_sound(cavity_, ring[r]) || pinches(ring[r], kNone)))
        continue;
      goal = least, core = {edge[0], edge[1], kNone}, core_size = 2, target = ring[r];
    }
  }
  for (std::uint32_t f = 0; f < 4; ++f) {
    const FaceCode face = tet * 4 + f, behind = mesh_.mesh.to_neighbor[face];
    if (behind == kNone || mesh_.mesh.is_fixed(face)) continue;
    if (mesh_.to_quality[behind / 4] < mesh_.to_quality[tet]) continue;
    const std::array<std::uint32_t, 3> c{v[tets::kFaceVerts[f][0]], v[tets::kFaceVerts[f][1]],
                                         v[tets::kFaceVerts[f][2]]};
    if (!mesh_.collect(c, tet, cavity_)) continue;
    const std::uint32_t apex = mesh_.mesh.to_vert[behind];
    const double least = mesh_.evaluate(cavity_, apex, goal, made_);
    if (least > goal) goal = least, core = c, core_size = 3, target = apex;
  }
  if (target == kNone) return Verdict::NoGain;
  mesh_.collect(std::span(core).first(core_size), tet, cavity_);
  mesh_.evaluate(cavity_, target, -1, made_);
  mesh_.reconnect(cavity_, target, made_);
  return Verdict::Done;
}

std::size_t Passes::swap(double limit) {
  std::size_t done = 0;
  const auto bound = static_cast<float>(cube(limit));
  const auto size = static_cast<std::uint32_t>(mesh_.mesh.size());
  for (std::uint32_t tet = 0; tet < size; ++tet) {
    if (tet % 4096 == 0) runner_.check_cancelled();
    const float quality = mesh_.to_quality[tet];
    if (!(quality < bound) || (quality > kPoor && !mesh_.is_active(tet))) continue;
    const Verdict verdict = swap_at(tet);
    count(counts_.swaps, verdict);
    done += verdict == Verdict::Done;
  }
  return done;
}

// Leads a vertex of the surface that does not lie on the model there, or as far as its tets bear: it was made beside
// the model because they would have been inverted. NoGain: it does lie there. Pre: cavity_ is the ball of v.
Verdict Passes::lead_to_model(std::uint32_t v) {
  const Vec3 x = mesh_.point(v);
  const auto spot = project_(mesh_.to_entity[v].unpack(), x);
  if (!spot) return Verdict::NoGain;
  const Vec3 way = spot->point - x;
  const std::uint32_t* beside = mesh_.verts(cavity_.tets[0]);
  if (norm2(way) <= kOnModel * kOnModel * norm2(mesh_.point(beside[beside[0] == v ? 1 : 0]) - x))
    return Verdict::NoGain;
  const VertexMetric old_metric = mesh_.to_metric[v];
  const double bearable = std::max(cube(kLeastLed), std::min(cube(options_.floor), kSplitLoss * cavity_.least));
  for (double share = 1; share > 0.1; share *= 0.5) {
    std::uint32_t hint = mesh_.to_hint[v];
    mesh_.mesh.points[v] = x + share * way;
    mesh_.set_metric(v, source_.at(mesh_.point(v), hint));
    if (!(mesh_.evaluate(cavity_, v, bearable, made_) > bearable)) continue;
    for (std::size_t i = 0; i < cavity_.tets.size(); ++i) {
      mesh_.to_quality[cavity_.tets[i]] = made_[i];
      for (int j = 0; j < 4; ++j) mesh_.to_state[mesh_.verts(cavity_.tets[i])[j]] |= kChanged | kUnsettled;
    }
    mesh_.to_hint[v] = hint;
    return Verdict::Done;
  }
  mesh_.mesh.points[v] = x;
  mesh_.to_metric[v] = old_metric;
  return Verdict::Surface;
}

Verdict Passes::move(std::uint32_t v) {
  if (mesh_.to_frozen[v]) return Verdict::Frozen;
  const int dim = mesh_.dim_of(v);
  if (dim == 0) return Verdict::Classification;
  if (!mesh_.collect(std::span(&v, 1), mesh_.vert_to_tet[v], cavity_)) return Verdict::TooLarge;
  if (dim < 3 && project_) {
    const Verdict led = lead_to_model(v);
    if (led != Verdict::NoGain) return led;
  }
  const std::size_t size = cavity_.tets.size();
  if (star_.size() < size) star_.resize(size);
  const Vec3 x = mesh_.point(v);
  const VertexMetric old_metric = mesh_.to_metric[v];
  const Root root(old_metric.tensor);
  double sum_before = 0;
  for (std::size_t i = 0; i < size; ++i) {
    const std::uint32_t tet = cavity_.tets[i];
    const std::uint32_t* verts = mesh_.verts(tet);
    const auto& [a, c, b] = tets::kFaceVerts[cavity_.corners[i][0]];
    star_[i] = tets::star_tet(root.apply(mesh_.point(verts[a]) - x), root.apply(mesh_.point(verts[b]) - x),
                              root.apply(mesh_.point(verts[c]) - x));
    sum_before += 1 / double{mesh_.to_quality[tet]};
  }
  Vec3 step = root.solve(tets::find_newton_step(std::span(star_).first(size), {}, tets::kSurelyPositive));
  mesh_.to_state[v] &= static_cast<std::uint8_t>(~kUnsettled);
  if (step == Vec3{}) return Verdict::NoGain;
  if (dim < 3) {
    if (cavity_.surface.empty()) return Verdict::Classification;
    if (dim == 2) {
      Vec3 normal;
      for (const FaceCode face : cavity_.surface) {
        const Vec3 one = normal_of(mesh_, mesh_.surface.find(verts_of(mesh_.mesh, face))->verts);
        if (!project_ && normal != Vec3{} && !(dot(one, normalized(normal)) > kFlat)) return Verdict::Surface;
        normal += one;
      }
      normal = normalized(normal);
      step -= dot(step, normal) * normal;
    } else {
      std::array<Vec3, 2> ends;
      int found = 0;
      std::uint32_t first = kNone;
      for (const FaceCode face : cavity_.surface)
        for (const std::uint32_t u : verts_of(mesh_.mesh, face)) {
          if (u == v || u == first || mesh_.surface.find_edge(u, v) == kNone || found == 2) continue;
          if (found == 0) first = u;
          ends[found++] = mesh_.point(u);
        }
      if (found != 2) return Verdict::Classification;
      const Vec3 along = normalized(ends[1] - ends[0]);
      const bool bends = dot(normalized(x - ends[0]), normalized(ends[1] - x)) < kFlat;
      if (!project_ && (bends || !lies_in_planes(cavity_))) return Verdict::Surface;
      step = dot(step, along) * along;
    }
  }
  const double bearable = std::min(cavity_.least, cube(0.4));
  for (int attempt = 0; attempt < 3; ++attempt, step *= 0.5) {
    Vec3 place = x + step;
    if (dim < 3 && project_) {
      const auto spot = project_(mesh_.to_entity[v].unpack(), place);
      if (!spot || norm2(spot->point - place) > norm2(step)) continue;
      place = spot->point;
    }
    std::uint32_t hint = mesh_.to_hint[v];
    mesh_.mesh.points[v] = place;
    mesh_.set_metric(v, source_.at(place, hint));
    double sum = 0;
    if (mesh_.evaluate(cavity_, v, bearable * 0.9999, made_) > bearable * 0.9999) {
      for (const float quality : made_) sum += 1 / double{quality};
      if (sum < sum_before) {
        for (std::size_t i = 0; i < size; ++i) mesh_.to_quality[cavity_.tets[i]] = made_[i];
        mesh_.to_hint[v] = hint;
        if (dot(old_metric.tensor, place - x) > kMoved * kMoved) {
          for (const std::uint32_t tet : cavity_.tets)
            for (int j = 0; j < 4; ++j) mesh_.to_state[mesh_.verts(tet)[j]] |= kUnsettled;
          mesh_.to_state[v] |= kChanged;
        }
        mesh_.to_state[v] &= static_cast<std::uint8_t>(~kUnsettled);
        return Verdict::Done;
      }
    }
  }
  mesh_.mesh.points[v] = x;
  mesh_.to_metric[v] = old_metric;
  return Verdict::NoGain;
}

std::size_t Passes::smooth(double limit) {
  std::size_t done = 0;
  const auto bound = static_cast<float>(cube(limit));
  std::vector<std::uint8_t> visited(mesh_.mesh.points.size(), 0);
  for (std::uint32_t tet = 0; tet < mesh_.mesh.size(); ++tet) {
    if (tet % 4096 == 0) runner_.check_cancelled();
    if (!(mesh_.to_quality[tet] < bound)) continue;
    for (std::uint32_t i = 0; i < 4; ++i) {
      const std::uint32_t v = mesh_.verts(tet)[i];
      if (visited[v] != 0) continue;
      if (mesh_.to_quality[tet] > kPoor && (mesh_.to_state[v] & kUnsettled) == 0) continue;
      visited[v] = 1;
      const Verdict verdict = move(v);
      count(counts_.moves, verdict);
      done += verdict == Verdict::Done;
    }
  }
  return done;
}

}  // namespace tetloom::adapt
