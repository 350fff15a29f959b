#include <algorithm>
#include <cmath>

#include "adapt/kernel/passes.hpp"

namespace tetloom::adapt {

namespace {

using tets::cube;
using tets::verts_of;

bool has(const std::uint32_t* v, std::uint32_t vert) {
  return v[0] == vert || v[1] == vert || v[2] == vert || v[3] == vert;
}

}  // namespace

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

// Marks the vertices of a cavity that were not marked yet. False: an edge from `to` to one would be longer than
// `longest`.
bool Passes::mark_new_ends(const Cavity& cavity, std::uint32_t to, double longest) {
  for (const std::uint32_t tet : cavity.tets) {
    const std::uint32_t* v = mesh_.verts(tet);
    for (int j = 0; j < 4; ++j) {
      if (marks_[v[j]] == mark_) continue;
      marks_[v[j]] = mark_;
      if (bound_of(v[j], to) > longest * longest && mesh_.length_of(v[j], to) > longest) return false;
    }
  }
  return true;
}

// Whether an edge from `to` to a vertex of the ball of `from` would be longer than `longest`. Pre: cavity_ is that
// ball.
bool Passes::makes_long_edge(std::uint32_t from, std::uint32_t to, double longest) {
  ++mark_;
  marks_.resize(std::max(marks_.size(), mesh_.mesh.points.size()), 0);
  marks_[from] = marks_[to] = mark_;
  return !mark_new_ends(cavity_, to, longest);
}

// The cubed quality that a collapse must exceed where it replaces tets the worst of which has `least`.
double Passes::bearable_collapse(double least) const {
  return std::max(cube(options_.floor), std::min(least, cube(options_.collapsible)));
}

// Whether `from` can be collapsed into `to`, better than to `best`, which is raised then. Pre: cavity_ is the ball of
// `from`.
Verdict Passes::judge_collapse(std::uint32_t from, std::uint32_t to, double longest, double& best) {
  if (!can_collapse(from, to)) return Verdict::Classification;
  if (makes_long_edge(from, to, longest)) return Verdict::Length;
  const double goal = std::max(best, bearable_collapse(cavity_.least));
  const double least = mesh_.evaluate(cavity_, to, goal, made_);
  if (!(least > goal)) return Verdict::Quality;
  if (!keeps_surface(cavity_, to)) return Verdict::Surface;
  best = least;
  return Verdict::Done;
}

// Fills `ball` unless v has to stay anyway.
Verdict Passes::collect_ball(std::uint32_t v, Cavity& ball) const {
  if (mesh_.to_frozen[v]) return Verdict::Frozen;
  return mesh_.collect(std::span(&v, 1), mesh_.vert_to_tet[v], ball) ? Verdict::Done : Verdict::TooLarge;
}

bool Passes::has_vertex(const Cavity& cavity, std::uint32_t v) const {
  return std::any_of(cavity.tets.begin(), cavity.tets.end(),
                     [&](std::uint32_t tet) { return mesh_.corner_of(tet, v) < 4; });
}

// Nothing where a and b have no edge any more.
std::optional<Verdict> Passes::collapse(std::uint32_t a, std::uint32_t b, double longest) {
  Verdict first = collect_ball(a, cavity_);
  const bool has_ball = first == Verdict::Done;
  if (has_ball && !has_vertex(cavity_, b)) return std::nullopt;
  double best = 0;
  if (has_ball) first = judge_collapse(a, b, longest, best);
  std::swap(cavity_, other_), std::swap(made_, other_made_);
  Verdict second = collect_ball(b, cavity_);
  if (second == Verdict::Done) {
    if (!has_ball && !has_vertex(cavity_, a)) return std::nullopt;
    second = judge_collapse(b, a, longest, best);
  }
  if (second == Verdict::Done) {
    mesh_.reconnect(cavity_, a, made_);
    return Verdict::Done;
  }
  std::swap(cavity_, other_), std::swap(made_, other_made_);
  if (first == Verdict::Done) {
    mesh_.reconnect(cavity_, b, made_);
    return Verdict::Done;
  }
  const Verdict refused = std::max(first, second);
  if (std::min(first, second) <= Verdict::TooLarge || refused < Verdict::Quality) return refused;
  const Verdict merged = merge(a, b, longest);
  if (merged == Verdict::Done) return merged;
  const bool done = (first == Verdict::Quality && collapse_with_swaps(cavity_, b, longest)) ||
                    (second == Verdict::Quality && collapse_with_swaps(other_, a, longest));
  return done ? Verdict::Done : merged;
}

// A collapse into `to` that needs swaps first. Pre: `ball` is that of the vertex that goes.
bool Passes::collapse_with_swaps(const Cavity& ball, std::uint32_t to, double longest) {
  if (mesh_.dim_of(ball.core[0]) < 3) return false;
  if (!star_cavity_.find(ball, to, bearable_collapse(ball.least))) return false;
  for (const std::uint32_t v : star_cavity_.link())
    if (bound_of(v, to) > longest * longest && mesh_.length_of(v, to) > longest) return false;
  star_cavity_.fill();
  return true;
}

// A collapse of two vertices of the same entity into the middle between them: b moves there, then a is collapsed into
// it. Edges that a collapse into an end makes too long are shorter so. Pre: cavity_ and other_ are their balls.
Verdict Passes::merge(std::uint32_t a, std::uint32_t b, double longest) {
  const int dim = mesh_.dim_of(a);
  if (dim < 2 || !(mesh_.to_entity[a] == mesh_.to_entity[b])) return Verdict::Classification;
  if (!can_collapse(a, b)) return Verdict::Classification;
  const Vec3 x = mesh_.point(b);
  Vec3 middle = 0.5 * (mesh_.point(a) + x);
  if (dim == 2 && project_) {
    const auto spot = project_(mesh_.to_entity[b].unpack(), middle);
    if (!spot || norm2(spot->point - middle) > norm2(middle - x)) return Verdict::Surface;
    middle = spot->point;
  }
  const std::vector<Vec3> normals = normals_of(other_);
  const VertexMetric old_metric = mesh_.to_metric[b];
  const BackgroundTet old_hint = mesh_.to_hint[b];
  mesh_.mesh.points[b] = middle;
  mesh_.set_metric(b, source_.at(middle, mesh_.to_hint[b]));
  const Verdict verdict = merge_at(a, b, normals, longest);
  if (verdict == Verdict::Done) return verdict;
  mesh_.mesh.points[b] = x;
  mesh_.to_metric[b] = old_metric, mesh_.to_hint[b] = old_hint;
  return verdict;
}

// Collapses a into b, which has moved. Pre: cavity_ and other_ are the balls of a and b, `normals` were those of the
// surface of the second before.
Verdict Passes::merge_at(std::uint32_t a, std::uint32_t b, const std::vector<Vec3>& normals, double longest) {
  if (makes_long_edge(a, b, longest) || !mark_new_ends(other_, b, longest)) return Verdict::Length;
  const double goal = bearable_collapse(std::min(cavity_.least, other_.least));
  if (!(mesh_.evaluate(cavity_, b, goal, made_) > goal)) return Verdict::Quality;
  beside_.clear();
  for (const std::uint32_t tet : other_.tets) {
    const std::uint32_t* v = mesh_.verts(tet);
    const bool vanishes = has(v, a);
    beside_.push_back(vanishes ? 0 : static_cast<float>(mesh_.quality_of(v[0], v[1], v[2], v[3])));
    if (!vanishes && !(double{beside_.back()} > goal)) return Verdict::Quality;
  }
  if (!turns_no_normal(other_, normals)) return Verdict::Surface;
  if (!keeps_surface(cavity_, b)) return Verdict::Surface;
  for (std::size_t i = 0; i < other_.tets.size(); ++i) {
    if (!(beside_[i] > 0)) continue;
    mesh_.to_quality[other_.tets[i]] = beside_[i];
    mesh_.mark_changed(other_.tets[i]);
  }
  mesh_.reconnect(cavity_, b, made_);
  return Verdict::Done;
}

}  // namespace tetloom::adapt
