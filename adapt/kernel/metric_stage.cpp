#include "adapt/kernel/metric_stage.hpp"

#include <algorithm>
#include <cmath>

namespace tetloom::adapt {

namespace {

// B = S T S with S symmetric.
Tensor between(const Tensor& s, const Tensor& t) {
  const Vec3 x = t * Vec3{s.xx, s.xy, s.xz}, y = t * Vec3{s.xy, s.yy, s.yz}, z = t * Vec3{s.xz, s.yz, s.zz};
  const auto row = [&](const Vec3& v) { return s * v; };
  const Vec3 a = row(x), b = row(y), c = row(z);
  return {a.x, 0.5 * (a.y + b.x), b.y, 0.5 * (a.z + c.x), 0.5 * (b.z + c.y), c.z};
}

// The metric in which the tet is regular with edges of length 1: with the edges e1, e2, e3 from one corner and those of
// such a tet in the columns of R, M = transpose(R inverse(E)) (R inverse(E)).
Tensor implied_by(const Vec3& e1, const Vec3& e2, const Vec3& e3) {
  const double det = dot(cross(e1, e2), e3);
  const Vec3 g1 = cross(e2, e3) / det, g2 = cross(e3, e1) / det, g3 = cross(e1, e2) / det;
  // transpose(R) R has 1 on its diagonal and 1/2 beside it.
  const Vec3 sum = g1 + g2 + g3;
  return 0.5 * (outer(g1) + outer(g2) + outer(g3) + outer(sum));
}

}  // namespace

Tensor limited(const Tensor& asked, const Tensor& implied, double ratio) {
  if (!std::isfinite(ratio)) return asked;
  const Tensor half = 0.5 * implied;
  const double most = ratio * ratio;
  const Tensor ratios = between(exp(-1 * half), asked);
  if (trace(ratios) <= most) return asked;
  return between(exp(half), map_eigenvalues(ratios, [&](double value) { return std::min(value, most); }));
}

double refinement_of(const Tensor& asked, const Tensor& implied) {
  return std::sqrt(eigen(between(exp(-0.5 * implied), asked)).values[2]);
}

Tensor MetricStage::asked_at(const Vec3& x, const BackgroundPlace& place) const {
  return function_ ? function_(x) : exp(background_.log_metric_at(place));
}

Tensor MetricStage::implied_log_at(const BackgroundPlace& place) const {
  return background_.implied_log_at(place, implied_);
}

Tensor MetricStage::at(const Vec3& x, BackgroundTet& hint) const {
  if (function_ && !std::isfinite(ratio_)) return function_(x);
  const BackgroundPlace place = background_.locate(x, hint);
  hint = place.tet;
  const Tensor asked = asked_at(x, place);
  return std::isfinite(ratio_) ? limited(asked, implied_log_at(place), ratio_) : asked;
}

double MetricStage::refinement_at(const Vec3& x, BackgroundTet& hint) const {
  const BackgroundPlace place = background_.locate(x, hint);
  hint = place.tet;
  return refinement_of(asked_at(x, place), implied_log_at(place));
}

void ImpliedMetric::add(const TetView& some, const BlockLoop& loop) {
  // Added up in the order of the tets, some of which are computed at a time.
  constexpr std::size_t kGrain = std::size_t{1} << 12, kAtOnce = 64 * kGrain;
  struct Weighted {
    Tensor logarithm;
    double volume = 0;
  };
  std::vector<Weighted> tets(std::min(kAtOnce, some.tets.size()));
  for (std::size_t first = 0; first < some.tets.size(); first += kAtOnce) {
    const std::size_t count = std::min(kAtOnce, some.tets.size() - first);
    loop.for_blocks(count, kGrain, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) {
        const TetVerts& v = some.tets[first + i];
        const Vec3& x = some.points[v[0]];
        const Vec3 e1 = some.points[v[1]] - x, e2 = some.points[v[2]] - x, e3 = some.points[v[3]] - x;
        tets[i] = {log(implied_by(e1, e2, e3)), std::abs(dot(cross(e1, e2), e3))};
      }
    });
    for (std::size_t i = 0; i < count; ++i)
      for (const std::uint32_t vert : some.tets[first + i])
        logs_[vert] += tets[i].volume * tets[i].logarithm, volumes_[vert] += tets[i].volume;
  }
}

std::vector<Tensor> ImpliedMetric::finish() {
  for (std::size_t v = 0; v < logs_.size(); ++v)
    if (volumes_[v] > 0) logs_[v] *= 1 / volumes_[v];
  volumes_ = {};
  return std::move(logs_);
}

std::vector<Tensor> implied_metric(const TetView& mesh, const BlockLoop& loop) {
  ImpliedMetric metric(mesh.points.size());
  metric.add(mesh, loop);
  return metric.finish();
}

}  // namespace tetloom::adapt
