// Projection of points onto a face: closed forms where they exist, else a damped Newton iteration inside the face's
// parameter box, started from the guess or from a grid of samples.
#include <algorithm>

#include "core/cad/detail/cad_face.hpp"
#include "core/cad/detail/occt_guard.hpp"

namespace tetloom::cad {
namespace {

constexpr int kMaxIterations = 50;
constexpr std::size_t kCandidates = 4;
constexpr double kConverged = 1e-12;  ///< of the face's size

struct Step {
  Vec2 uv;
  bool newton = false;  ///< from the full Hessian
};

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
  const double small = kConverged * length_scale_;
  SurfaceJet jet = surface_->jet(uv);
  double value = norm2(jet.point - x);
  bool converged = false;
  for (int i = 0; i < kMaxIterations && !converged; ++i) {
    const Vec3 r = jet.point - x;
    const bool freeze_u = blocked(uv.u, search_box_.lo.u, search_box_.hi.u, dot(r, jet.du));
    const bool freeze_v = blocked(uv.v, search_box_.lo.v, search_box_.hi.v, dot(r, jet.dv));
    Vec2 step = solve_step(jet, r, freeze_u, freeze_v);
    for (int halving = 0;; ++halving) {
      const Vec2 next = clamp(uv + step), moved = next - uv;
      const double length = norm(moved.u * jet.du) + norm(moved.v * jet.dv);
      const SurfaceJet there = surface_->jet(next);
      const double next_value = norm2(there.point - x);
      const bool tiny = length <= small || halving >= 30;
      if (next_value <= value || tiny) {
        converged = tiny;
        if (next_value <= value) uv = next, jet = there, value = next_value;
        break;
      }
      step = 0.5 * moved;
    }
  }
  return {{uv, jet.point, std::sqrt(value)}, converged};
}

void CadFace::make_samples() {
  const std::array<int, 2> pieces = surface_->pieces();
  const int nu = std::clamp(2 * pieces[0], 10, 40), nv = std::clamp(2 * pieces[1], 10, 40);
  for (int i = 0; i <= nu; ++i) {
    for (int j = 0; j <= nv; ++j) {
      const Vec2 uv{box_.lo.u + (box_.hi.u - box_.lo.u) * i / nu, box_.lo.v + (box_.hi.v - box_.lo.v) * j / nv};
      sample_uv_.push_back(uv);
      samples_.push_back(surface_->point(uv));
    }
  }
}

SurfacePoint CadFace::search(const Vec3& x) {
  if (samples_.empty()) make_samples();
  std::vector<std::pair<double, std::size_t>> order(samples_.size());
  for (std::size_t i = 0; i < samples_.size(); ++i) order[i] = {norm2(samples_[i] - x), i};
  const std::size_t count = std::min(kCandidates, order.size());
  std::partial_sort(order.begin(), order.begin() + static_cast<std::ptrdiff_t>(count), order.end());
  SurfacePoint best{{}, {}, HUGE_VAL};
  for (std::size_t k = 0; k < count; ++k) {
    const SurfacePoint found = descend(x, sample_uv_[order[k].second]).found;
    if (found.distance < best.distance) best = found;
  }
  best.uv = into_box(best.uv);
  return best;
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
      const Descent descent = descend(x, *guess);
      if (descent.converged) return descent.found;
    }
    return search(x);
  });
}

}  // namespace tetloom::cad
