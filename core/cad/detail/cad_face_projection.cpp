// Projection of points onto a face: closed forms where they exist, else a damped Newton iteration inside the face's
// parameter box, started from the guess or from a grid of samples.
#include <algorithm>

#include "core/cad/detail/cad_face.hpp"
#include "core/cad/detail/occt_guard.hpp"

namespace tetloom::cad {
namespace {

constexpr int kMostSteps = 50, kPoleDirections = 32;
constexpr int kHalvings = 16, kMostTrials = 3 * kHalvings;
constexpr double kLongestStep = 0.25;  ///< of the box, lest a step near a pole leaps to another branch
constexpr std::size_t kMostStarts = 4;
constexpr double kTurnPerSample = 0.3;  ///< radians
constexpr int kFewestSamples = 8, kMostSamples = 512, kMostInGrid = 16384;
constexpr double kConverged = 1e-12;  ///< of the face's size

/// The step that minimises the quadratic model of |S - x|²/2, with the directions frozen that a bound blocks.
Vec2 solve_step(const SurfaceJet& jet, const Vec3& r, bool freeze_u, bool freeze_v) {
  const double gu = dot(r, jet.du), gv = dot(r, jet.dv);
  const double e = dot(jet.du, jet.du), f = dot(jet.du, jet.dv), g = dot(jet.dv, jet.dv);
  double a = e + dot(r, jet.duu), b = f + dot(r, jet.duv), c = g + dot(r, jet.dvv);
  if (freeze_u || freeze_v) {
    if (freeze_u && freeze_v) return {};
    if (freeze_u) return {0, g > 0 ? -gv / (c > 0.1 * g ? c : g) : 0.0};
    return {e > 0 ? -gu / (a > 0.1 * e ? a : e) : 0.0, 0};
  }
  if (!(a > 0 && a * c - b * b > 1e-6 * e * g)) {  // not convex here: Gauss–Newton, regularised where S is singular
    a = e * (1 + 1e-6) + 1e-300, b = f, c = g * (1 + 1e-6) + 1e-300;
  }
  const double determinant = a * c - b * b;
  return {(b * gv - c * gu) / determinant, (b * gu - a * gv) / determinant};
}

/// Shorter and shorter steps; then along one parameter at a time, because where derivatives jump between spans the
/// full step may climb on the other side, however short.
Vec2 trial_step(const Vec2& full, int trial) {
  const double share = std::ldexp(1.0, -(trial % kHalvings));
  return {trial / kHalvings == 2 ? 0 : share * full.u, trial / kHalvings == 1 ? 0 : share * full.v};
}

bool blocked(double x, double lo, double hi, double gradient) {
  return (x <= lo && gradient > 0) || (x >= hi && gradient < 0);
}

}  // namespace

CadFace::Descent CadFace::descend(const Vec3& x, Vec2 uv) {
  const auto clamp = [&](const Vec2& p) {
    return Vec2{std::clamp(p.u, search_box_.lo.u, search_box_.hi.u),
                std::clamp(p.v, search_box_.lo.v, search_box_.hi.v)};
  };
  uv = clamp(uv);
  const Vec2 longest = kLongestStep * (box_.hi - box_.lo);
  const double small = kConverged * length_scale_;
  SurfaceJet jet = surface_->jet(uv);
  double value = norm2(jet.point - x);
  bool converged = false, stuck = false;
  for (int i = 0; i < kMostSteps && !converged && !stuck; ++i) {
    const Vec3 r = jet.point - x;
    const bool freeze_u = blocked(uv.u, search_box_.lo.u, search_box_.hi.u, dot(r, jet.du));
    const bool freeze_v = blocked(uv.v, search_box_.lo.v, search_box_.hi.v, dot(r, jet.dv));
    Vec2 full = solve_step(jet, r, freeze_u, freeze_v);
    full = {std::clamp(full.u, -longest.u, longest.u), std::clamp(full.v, -longest.v, longest.v)};
    stuck = true;
    for (int trial = 0; trial < kMostTrials && stuck; ++trial) {
      const Vec2 next = clamp(uv + trial_step(full, trial)), moved = next - uv;
      const SurfaceJet there = surface_->jet(next);
      const double next_value = norm2(there.point - x);
      converged = trial < kHalvings && norm(moved.u * jet.du) + norm(moved.v * jet.dv) <= small;
      if (next_value <= value) uv = next, jet = there, value = next_value, stuck = false;
      if (converged) break;
    }
  }
  return {{uv, jet.point, std::sqrt(value)}, converged};
}

// At a pole every direction of the collapsed parameter is the same point, and the descent does not see in which one to
// go on. It goes in the one that points at x most.
std::optional<Vec2> CadFace::way_from_pole(const Vec3& x, const Vec2& uv) {
  const SurfaceDerivatives at = surface_->derivatives(uv);
  const Vec2 width = box_.hi - box_.lo;
  const bool u_collapsed = norm(at.du) * width.u <= kCollapsed * length_scale_;
  const bool v_collapsed = norm(at.dv) * width.v <= kCollapsed * length_scale_;
  if (u_collapsed == v_collapsed) return std::nullopt;
  const Vec2 inside = pull_inside(uv, 1) - uv;
  std::optional<Vec2> best;
  double best_gain = 0;
  for (int k = 0; k < kPoleDirections; ++k) {
    const double share = (k + 0.5) / kPoleDirections;
    const Vec2 start = u_collapsed ? Vec2{at_share(share, 0).u, uv.v} : Vec2{uv.u, at_share(0, share).v};
    const SurfaceDerivatives d = surface_->derivatives(start);
    const Vec3 along = u_collapsed ? (inside.v > 0 ? 1.0 : -1.0) * d.dv : (inside.u > 0 ? 1.0 : -1.0) * d.du;
    const double gain = dot(x - at.point, along) / norm(along);
    if (!(gain > best_gain)) continue;
    best_gain = gain;
    const double step = std::min(gain / norm(along), 0.5 * std::abs(u_collapsed ? width.v : width.u));
    best = start + (u_collapsed ? Vec2{0, std::copysign(step, inside.v)} : Vec2{std::copysign(step, inside.u), 0});
  }
  return best;
}

CadFace::Descent CadFace::descend_past_poles(const Vec3& x, const Vec2& start) {
  Descent descent = descend(x, start);
  if (const std::optional<Vec2> way = way_from_pole(x, descent.found.uv)) {
    const Descent other = descend(x, *way);
    if (other.found.distance < descent.found.distance) return other;
  }
  return descent;
}

Vec2 CadFace::at_share(double u, double v) const {
  return {box_.lo.u + (box_.hi.u - box_.lo.u) * u, box_.lo.v + (box_.hi.v - box_.lo.v) * v};
}

// Enough samples that the surface turns little between two of them: a screw thread takes hundreds along it.
int CadFace::samples_along(bool u, int pieces) {
  constexpr int probes = 256;
  double turning = 0;
  for (const double other : {0.1, 0.5, 0.9}) {
    double sum = 0;
    Vec3 last, before;
    for (int i = 0; i <= probes; ++i) {
      const double share = static_cast<double>(i) / probes;
      const Vec3 p = surface_->point(u ? at_share(share, other) : at_share(other, share));
      if (i > 0) {
        const Vec3 along = normalized(p - last);
        if (i > 1) sum += std::acos(std::clamp(dot(along, before), -1.0, 1.0));
        before = along;
      }
      last = p;
    }
    turning = std::max(turning, sum);
  }
  return std::clamp(std::max(2 * pieces, static_cast<int>(turning / kTurnPerSample)), kFewestSamples, kMostSamples);
}

// At the middles of cells, because poles and seams lie on the sides of the box.
void CadFace::make_samples() {
  const std::array<int, 2> pieces = surface_->pieces();
  sample_count_ = {samples_along(true, pieces[0]), samples_along(false, pieces[1])};
  while (sample_count_[0] * sample_count_[1] > kMostInGrid) {
    int& larger = sample_count_[0] > sample_count_[1] ? sample_count_[0] : sample_count_[1];
    larger = std::max(kFewestSamples, larger * 3 / 4);
  }
  for (int i = 0; i < sample_count_[0]; ++i) {
    for (int j = 0; j < sample_count_[1]; ++j) {
      sample_uv_.push_back(at_share((i + 0.5) / sample_count_[0], (j + 0.5) / sample_count_[1]));
      samples_.push_back(surface_->point(sample_uv_.back()));
    }
  }
}

SurfacePoint CadFace::search(const Vec3& x) {
  if (samples_.empty()) make_samples();
  sample_values_.resize(samples_.size());
  for (std::size_t i = 0; i < samples_.size(); ++i) sample_values_[i] = norm2(samples_[i] - x);
  std::vector<std::pair<double, std::size_t>> minima;
  for (int i = 0; i < sample_count_[0]; ++i)
    for (int j = 0; j < sample_count_[1]; ++j)
      if (is_least_around(i, j)) {
        const std::size_t index = static_cast<std::size_t>(i) * static_cast<std::size_t>(sample_count_[1]) + j;
        minima.emplace_back(sample_values_[index], index);
      }
  std::sort(minima.begin(), minima.end());
  SurfacePoint best{{}, {}, HUGE_VAL};
  for (std::size_t k = 0; k < std::min(kMostStarts, minima.size()); ++k) {
    const SurfacePoint found = descend_past_poles(x, sample_uv_[minima[k].second]).found;
    if (found.distance < best.distance) best = found;
  }
  best.uv = into_box(best.uv);
  return best;
}

bool CadFace::is_least_around(int i, int j) const {
  const auto value = [&](int a, int b) { return sample_values_[static_cast<std::size_t>(a * sample_count_[1] + b)]; };
  for (int a = std::max(0, i - 1); a <= std::min(sample_count_[0] - 1, i + 1); ++a)
    for (int b = std::max(0, j - 1); b <= std::min(sample_count_[1] - 1, j + 1); ++b)
      if (value(a, b) < value(i, j)) return false;
  return true;
}

Vec2 CadFace::into_box(Vec2 uv) const {
  const auto shift = [](double t, double lo, double hi, double period) {
    if (!(period > 0) || (t >= lo && t <= hi)) return t;
    const double middle = 0.5 * (lo + hi);
    return t + period * std::round((middle - t) / period);
  };
  return {shift(uv.u, box_.lo.u, box_.hi.u, period_.u), shift(uv.v, box_.lo.v, box_.hi.v, period_.v)};
}

SurfacePoint CadFace::closest_point(const Vec3& x, const std::optional<Vec2>& guess) {
  return translate_failures(who_, ErrorCode::FaceFailed, "projection", [&] {
    const Vec2 hint = guess ? *guess : 0.5 * (box_.lo + box_.hi);
    if (std::optional<Vec2> uv = surface_->invert(x, hint)) {
      if (!guess) *uv = into_box(*uv);
      const Vec3 p = surface_->point(*uv);
      return SurfacePoint{*uv, p, distance(p, x)};
    }
    if (guess) {
      const Descent descent = descend_past_poles(x, *guess);
      if (descent.converged) return descent.found;
    }
    return search(x);
  });
}

}  // namespace tetloom::cad
