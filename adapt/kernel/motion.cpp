#include <algorithm>
#include <cmath>

#include "adapt/kernel/passes.hpp"
#include "core/tets/newton_step.hpp"
#include "core/tets/tet_pairs.hpp"

namespace tetloom::adapt {

namespace {

using tets::cube;
using tets::pairs::pair_of;
using tets::pairs::PairVec;

constexpr double kMoved = 0.25;            // in the metric: what is beside may then have another place
constexpr double kOnModel = 1e-6;          // of an edge: nearer than that is on the model
constexpr double kLongestOfRemoval = 2;    // edge that the removal of a vertex may make
constexpr double kBearable = 0.4;          // mean ratio that a tet may fall to for the good of its neighbours
constexpr double kNoWorseMotion = 0.9999;  // but for round-off
// Of the badness of its tets. As the metric is that of where a vertex is, it could go to and fro for ever without gain.
constexpr double kWorthAMove = 0.999;
constexpr int kAttempts = 3;

// M = transpose(U) U, so that U e is as long in space as e in the metric.
struct Root {
  double xx, xy, xz, yy, yz, zz;
  explicit Root(const Tensor& m) {
    xx = std::sqrt(m.xx), xy = m.xy / xx, xz = m.xz / xx;
    yy = std::sqrt(m.yy - xy * xy), yz = (m.yz - xy * xz) / yy;
    zz = std::sqrt(m.zz - xz * xz - yz * yz);
  }
  Vec3 apply(const Vec3& e) const { return {xx * e.x + xy * e.y + xz * e.z, yy * e.y + yz * e.z, zz * e.z}; }
  PairVec apply(const PairVec& e) const { return {xx * e.x + xy * e.y + xz * e.z, yy * e.y + yz * e.z, zz * e.z}; }
  Vec3 solve(const Vec3& y) const {
    Vec3 e;
    e.z = y.z / zz, e.y = (y.y - yz * e.z) / yy, e.x = (y.x - xy * e.y - xz * e.z) / xx;
    return e;
  }
};

// The points of the face opposite to the core of the i-th tet of a ball.
std::array<const Vec3*, 3> opposite_face(const CavityMesh& mesh, const Cavity& ball, std::size_t i) {
  const std::uint32_t* verts = mesh.verts(ball.tets[i]);
  const auto& [a, b, c] = tets::kFaceVerts[ball.corners[i][0]];
  return {&mesh.point(verts[a]), &mesh.point(verts[b]), &mesh.point(verts[c])};
}

}  // namespace

// Moves a vertex of the surface that does not lie on the model to it, or as far as its tets bear: it was made beside
// the model because they would have been inverted. NoGain: it does lie there. Pre: cavity_ is the ball of v.
Verdict Passes::snap_to_model(std::uint32_t v) {
  const Vec3 x = mesh_.point(v);
  const auto spot = project_(mesh_.to_entity[v].unpack(), x);
  if (!spot) return Verdict::NoGain;
  const Vec3 way = spot->point - x;
  const std::uint32_t* beside = mesh_.verts(cavity_.tets[0]);
  if (norm2(way) <= kOnModel * kOnModel * norm2(mesh_.point(beside[beside[0] == v ? 1 : 0]) - x))
    return Verdict::NoGain;
  const VertexMetric old_metric = mesh_.to_metric[v];
  const double bearable = std::min(cube(options_.floor), kNoWorseMotion * cavity_.least);
  for (double share = 1; share > 0.1; share *= 0.5) {
    BackgroundTet hint = mesh_.to_hint[v];
    mesh_.mesh.points[v] = x + share * way;
    mesh_.set_metric(v, source_.at(mesh_.point(v), hint));
    if (!(mesh_.evaluate_all(cavity_, v, bearable, made_) > bearable)) continue;
    take_made_qualities();
    for (const std::uint32_t tet : cavity_.tets) mesh_.mark_changed(tet);
    mesh_.to_hint[v] = hint;
    counts_.unsnapped += share < 1;
    return Verdict::Done;
  }
  mesh_.mesh.points[v] = x;
  mesh_.to_metric[v] = old_metric;
  return Verdict::Surface;
}

// Collapses a vertex that cannot be snapped to the model into one of the surface beside it. Pre: cavity_ is its ball.
bool Passes::remove_from_surface(std::uint32_t v) {
  std::vector<std::uint32_t> near;
  for (const FaceCode face : cavity_.surface)
    for (const std::uint32_t u : tets::verts_of(mesh_.mesh, face))
      if (u != v && std::find(near.begin(), near.end(), u) == near.end()) near.push_back(u);
  double best = 0;
  std::uint32_t target = kNone;
  for (const std::uint32_t u : near)
    if (judge_collapse(v, u, kLongestOfRemoval, best) == Verdict::Done) target = u;
  if (target == kNone) return false;
  mesh_.evaluate(cavity_, target, -1, made_);
  mesh_.reconnect(cavity_, target, made_);
  return true;
}

void Passes::take_made_qualities() {
  for (std::size_t i = 0; i < cavity_.tets.size(); ++i) mesh_.to_quality[cavity_.tets[i]] = made_[i];
}

// A step of v that makes its tets better in the metric of where it is, in which star_ is measured then. `badness`: the
// sum of what they are worth now. Pre: cavity_ is the ball of v.
Vec3 Passes::find_step(std::uint32_t v, double& badness) {
  const std::size_t size = cavity_.tets.size();
  star_.resize(size);
  const PairVec x = pair_of(mesh_.point(v));
  const Root root(mesh_.to_metric[v].tensor);
  badness = 0;
  for (std::size_t i = 0; i < size; i += 2) {
    const std::size_t j = std::min(i + 1, size - 1);
    const auto [a, c, b] = opposite_face(mesh_, cavity_, i);
    const auto [e, g, f] = opposite_face(mesh_, cavity_, j);
    store(star_pair(root.apply(pair_of(*a, *e) - x), root.apply(pair_of(*b, *f) - x), root.apply(pair_of(*c, *g) - x)),
          star_[i], star_[j]);
  }
  for (const std::uint32_t tet : cavity_.tets) badness += 1 / double{mesh_.to_quality[tet]};
  badness += tets::size_badness(star_, {}, options_.size_weight);
  return root.solve(tets::find_newton_step(star_, {}, tets::kSurelyPositive, options_.size_weight));
}

// Moves v to `place` if that lowers the badness of its tets. Pre: star_ is measured at v.
bool Passes::try_place(std::uint32_t v, const Vec3& place, double bearable, double badness) {
  const Vec3 x = mesh_.point(v);
  const VertexMetric old_metric = mesh_.to_metric[v];
  BackgroundTet hint = mesh_.to_hint[v];
  double sum = tets::size_badness(star_, Root(old_metric.tensor).apply(place - x), options_.size_weight);
  mesh_.mesh.points[v] = place;
  mesh_.set_metric(v, source_.at(place, hint));
  bool better = mesh_.evaluate_all(cavity_, v, bearable, made_) > bearable;
  if (better) {
    for (const float quality : made_) sum += 1 / double{quality};
    better = sum < kWorthAMove * badness;
  }
  if (!better) {
    mesh_.mesh.points[v] = x;
    mesh_.to_metric[v] = old_metric;
    return false;
  }
  take_made_qualities();
  mesh_.to_hint[v] = hint;
  if (dot(old_metric.tensor, place - x) > kMoved * kMoved) {
    for (const std::uint32_t tet : cavity_.tets)
      for (int j = 0; j < 4; ++j) mesh_.to_state[mesh_.verts(tet)[j]] |= kUnsettled;
    mesh_.to_state[v] |= kChanged;
  }
  mesh_.to_state[v] &= static_cast<std::uint8_t>(~kUnsettled);
  return true;
}

Verdict Passes::move(std::uint32_t v) {
  if (mesh_.to_frozen[v]) return Verdict::Frozen;
  const int dim = mesh_.dim_of(v);
  if (dim == 0) return Verdict::Classification;
  if (!mesh_.collect(std::span(&v, 1), mesh_.vert_to_tet[v], cavity_)) return Verdict::TooLarge;
  if (dim < 3 && project_) {
    const Verdict snapped = snap_to_model(v);
    if (snapped == Verdict::Surface && remove_from_surface(v)) return Verdict::Done;
    counts_.unsnapped += snapped == Verdict::Surface;
    if (snapped != Verdict::NoGain) return snapped;
  }
  double badness = 0;
  Vec3 step = find_step(v, badness);
  mesh_.to_state[v] &= static_cast<std::uint8_t>(~kUnsettled);
  if (step == Vec3{}) return Verdict::NoGain;
  if (!keep_on_entity(v, step)) return Verdict::Surface;
  const Vec3 x = mesh_.point(v);
  const double bearable = kNoWorseMotion * std::min(cavity_.least, cube(kBearable));
  for (int attempt = 0; attempt < kAttempts; ++attempt, step *= 0.5) {
    Vec3 place = x + step;
    if (dim < 3 && project_) {
      const auto spot = project_(mesh_.to_entity[v].unpack(), place);
      if (!spot || norm2(spot->point - place) > norm2(step)) continue;
      place = spot->point;
    }
    if (try_place(v, place, bearable, badness)) return Verdict::Done;
  }
  return Verdict::NoGain;
}

}  // namespace tetloom::adapt
