#pragma once
// What a vertex asks for, and how well a tet fits what its vertices ask for.
#include <array>
#include <cstdint>

#include "tetloom/metric.hpp"
#include "tetloom/vec.hpp"

namespace tetloom::adapt {

/// A metric and its determinant.
struct VertexMetric {
  Tensor tensor;
  double det = 0;
};

/// Cubed mean ratio in `metric` of a tet with edges p, q, r from one vertex; 0 where it is flat or inverted. By UGAWG's
/// definition a tet's metric is that of the vertex at which the determinant is largest.
inline double cubed_mean_ratio(const Vec3& p, const Vec3& q, const Vec3& r, const VertexMetric& metric) {
  const double volume = dot(cross(p, q), r);
  if (!(volume > 0)) return 0;
  const Tensor& m = metric.tensor;
  // Over all pairs of four points, |xi - xj|^2 sums up to 4 sum |xi - x0|^2 - |sum (xi - x0)|^2.
  const Vec3 s = p + q + r;
  const auto sum = [&](double Vec3::*i, double Vec3::*j) {
    return 4 * (p.*i * p.*j + q.*i * q.*j + r.*i * r.*j) - s.*i * s.*j;
  };
  const double squares =
      m.xx * sum(&Vec3::x, &Vec3::x) + m.yy * sum(&Vec3::y, &Vec3::y) + m.zz * sum(&Vec3::z, &Vec3::z) +
      2 * (m.xy * sum(&Vec3::x, &Vec3::y) + m.xz * sum(&Vec3::x, &Vec3::z) + m.yz * sum(&Vec3::y, &Vec3::z));
  return 432 * volume * volume * metric.det / (squares * squares * squares);
}

/// A cubed mean ratio in `metric`, computed as above, beyond which orient3d > 0 is certain wherever the tet lies: a
/// sure bound, so that the exact predicate is asked for flat tets alone. Infinite for metrics too ill-conditioned for
/// one. Between 1e-9 and 1e-8 for aspect ratios up to 300.
///
/// With S the sum of the squares of three edges from one vertex, v = dot(cross(p, q), r) of differences of coordinates
/// is off by less than 1e-15 S^1.5: at most 8 roundings lie on any path to a sum of products whose magnitudes add up to
/// at most |p|_1 |q|_1 |r|_1 <= 3^1.5 |p| |q| |r| <= S^1.5. As squared edges in the metric add up to at least l S,
/// where l is its smallest eigenvalue, v^2 > 1e-30 S^3 where 432 v^2 det / (l S)^3 > 4.4e-28 det / l^3. Twice that
/// makes up for the roundings of these figures, as long as l exceeds 1e-10 times the trace.
double surely_positive_quality(const VertexMetric& metric);

/// The metric of a tet: that of its vertex at which the determinant is largest.
template <class Metrics>
const VertexMetric& densest_metric(const Metrics& metrics, const std::array<std::uint32_t, 4>& v) {
  const VertexMetric* metric = &metrics[v[0]];
  for (std::size_t i = 1; i < 4; ++i)
    if (metrics[v[i]].det > metric->det) metric = &metrics[v[i]];
  return *metric;
}

/// The cubed mean ratio of the tet with these vertices, in its metric.
template <class Points, class Metrics>
double cubed_mean_ratio(const Points& points, const Metrics& metrics, const std::array<std::uint32_t, 4>& v) {
  const Vec3& x = points[v[0]];
  return cubed_mean_ratio(points[v[1]] - x, points[v[2]] - x, points[v[3]] - x, densest_metric(metrics, v));
}

}  // namespace tetloom::adapt
