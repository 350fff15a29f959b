#include "tetloom/metric.hpp"

#include <algorithm>
#include <array>
#include <string>

#include "core/base/grain.hpp"
#include "tetloom/assert.hpp"
#include "tetloom/error.hpp"

namespace tetloom::adapt {
namespace {

[[noreturn]] void refuse(std::size_t vert, const Vec3& place, const std::string& what) {
  Diagnostic diagnostic;
  diagnostic.code = ErrorCode::InputUnsuitable;
  diagnostic.message = "the metric at vertex " + std::to_string(vert + 1) + " " + what;
  diagnostic.point = place;
  diagnostic.elements = {vert};
  throw Error(std::move(diagnostic));
}

void require_length(std::size_t found, std::size_t each, std::size_t points) {
  if (found != each * points)
    throw Error(ErrorCode::InvalidArgument, "a metric with " + std::to_string(found) + " values does not fit " +
                                                std::to_string(points) + " vertices, which need " +
                                                std::to_string(each) + " each");
}

/// The first vertex that is no good is named, whoever carries out the loop: blocks report instead of throwing.
template <class LogOf, class Explain>
MetricField make_field(std::span<const Vec3> points, const BlockLoop& loop, const LogOf& log_of,
                       const Explain& explain) {
  MetricField metric;
  metric.logs.resize(points.size());
  const auto bad = map_blocks(loop, points.size(), kElementGrain, points.size(),
                              [&](std::size_t begin, std::size_t end, std::size_t& first_bad) {
                                for (std::size_t v = begin; v < end; ++v) {
                                  if (log_of(v, metric.logs[v])) continue;
                                  first_bad = v;
                                  return;
                                }
                              });
  for (const std::size_t v : bad)
    if (v < points.size()) refuse(v, points[v], explain(v));
  return metric;
}

bool log_of_size(double h, Tensor& logarithm) {
  if (!(h > 0) || !std::isfinite(h)) return false;
  logarithm = log_isotropic(h);
  return true;
}

bool log_of_tensor(const Tensor& m, Tensor& logarithm) {
  if (!is_positive_definite(m)) return false;
  logarithm = log(m);
  return is_finite(logarithm);
}

std::string explain_size(double h) {
  return std::isfinite(h) ? "asks for the size " + std::to_string(h) + ", which is not positive"
                          : "asks for a size that is no finite number";
}

std::string explain_tensor(const Tensor& m) {
  return is_finite(m) ? "is not positive definite" : "has entries that are no finite numbers";
}

Tensor tensor_of(const double* v, TensorOrder order) {
  if (order == TensorOrder::Medit) return {v[0], v[1], v[2], v[3], v[4], v[5]};
  return {v[0], v[3], v[1], v[5], v[4], v[2]};
}

constexpr double kSymmetry = 1e-6;

double asymmetry(const double* m) {
  return std::max({std::abs(m[1] - m[3]), std::abs(m[2] - m[6]), std::abs(m[5] - m[7])});
}
bool is_symmetric(const double* m) {
  double largest = 0;
  for (int i = 0; i < 9; ++i) largest = std::max(largest, std::abs(m[i]));
  return !(asymmetry(m) > kSymmetry * largest);
}
Tensor tensor_of_matrix(const double* m) {
  return {m[0], (m[1] + m[3]) / 2, m[4], (m[2] + m[6]) / 2, (m[5] + m[7]) / 2, m[8]};
}

}  // namespace

MetricField metric_from_sizes(std::span<const double> sizes, std::span<const Vec3> points, const BlockLoop& loop) {
  require_length(sizes.size(), 1, points.size());
  return make_field(
      points, loop, [&](std::size_t v, Tensor& logarithm) { return log_of_size(sizes[v], logarithm); },
      [&](std::size_t v) { return explain_size(sizes[v]); });
}

MetricField metric_from_tensors(std::span<const Tensor> tensors, std::span<const Vec3> points, const BlockLoop& loop) {
  require_length(tensors.size() * 6, 6, points.size());
  return make_field(
      points, loop, [&](std::size_t v, Tensor& logarithm) { return log_of_tensor(tensors[v], logarithm); },
      [&](std::size_t v) { return explain_tensor(tensors[v]); });
}

MetricField metric_from_field(const MeshField& field, TensorOrder order, std::span<const Vec3> points,
                              const BlockLoop& loop) {
  const double* values = field.values.data();
  switch (field.components) {
    case 1: return metric_from_sizes(field.values, points, loop);
    case 6:
      require_length(field.values.size(), 6, points.size());
      return make_field(
          points, loop,
          [&](std::size_t v, Tensor& logarithm) { return log_of_tensor(tensor_of(values + 6 * v, order), logarithm); },
          [&](std::size_t v) { return explain_tensor(tensor_of(values + 6 * v, order)); });
    case 9:
      require_length(field.values.size(), 9, points.size());
      return make_field(
          points, loop,
          [&](std::size_t v, Tensor& logarithm) {
            return is_symmetric(values + 9 * v) && log_of_tensor(tensor_of_matrix(values + 9 * v), logarithm);
          },
          [&](std::size_t v) {
            return is_symmetric(values + 9 * v) ? explain_tensor(tensor_of_matrix(values + 9 * v)) : "is not symmetric";
          });
    default:
      throw Error(ErrorCode::InputUnsuitable, "the field '" + field.name + "' has " + std::to_string(field.components) +
                                                  " components; a metric has 1, 6 or 9");
  }
}

MetricField metric_from_function(const std::function<Tensor(const Vec3&)>& metric, std::span<const Vec3> points,
                                 const BlockLoop& loop) {
  return make_field(
      points, loop, [&](std::size_t v, Tensor& logarithm) { return log_of_tensor(metric(points[v]), logarithm); },
      [&](std::size_t v) { return explain_tensor(metric(points[v])); });
}

MeshField field_of_metric(const MetricField& metric, TensorOrder order, const BlockLoop& loop) {
  MeshField field{"metric", 6, std::vector<double>(metric.size() * 6)};
  loop.for_blocks(metric.size(), kElementGrain, [&](std::size_t begin, std::size_t end) {
    for (std::size_t v = begin; v < end; ++v) {
      const Tensor m = metric.at(v);
      const std::array<double, 6> entries = order == TensorOrder::Medit
                                                ? std::array<double, 6>{m.xx, m.xy, m.yy, m.xz, m.yz, m.zz}
                                                : std::array<double, 6>{m.xx, m.yy, m.zz, m.xy, m.yz, m.xz};
      std::copy(entries.begin(), entries.end(), field.values.begin() + static_cast<std::ptrdiff_t>(v * 6));
    }
  });
  return field;
}

void require_valid(const MetricBounds& bounds) {
  if (!(bounds.h_min >= 0 && bounds.h_min <= bounds.h_max && bounds.h_max > 0 && std::isfinite(bounds.h_min)))
    throw Error(ErrorCode::InvalidArgument, "the smallest size must not be negative nor exceed the largest one");
  if (!(bounds.max_aspect >= 1)) throw Error(ErrorCode::InvalidArgument, "the largest aspect ratio must be at least 1");
}

Tensor bounded_log(const Tensor& logarithm, const MetricBounds& bounds) {
  EigenSystem e = eigen(logarithm);
  const std::array<double, 3> before = e.values;
  const double most = bounds.h_min > 0 ? -2 * std::log(bounds.h_min) : HUGE_VAL;
  const double least = -2 * std::log(bounds.h_max);  // minus infinity without a largest size
  for (double& value : e.values) value = std::clamp(value, least, most);
  const double by_aspect = e.values[2] - 2 * std::log(bounds.max_aspect);
  for (double& value : e.values) value = std::max(value, by_aspect);
  return e.values == before ? logarithm : compose(e);
}

void apply_bounds(MetricField& metric, const MetricBounds& bounds, const BlockLoop& loop) {
  require_valid(bounds);
  loop.for_blocks(metric.size(), kElementGrain, [&](std::size_t begin, std::size_t end) {
    for (std::size_t v = begin; v < end; ++v) metric.logs[v] = bounded_log(metric.logs[v], bounds);
  });
}

void intersect(MetricField& metric, const MetricField& other, const BlockLoop& loop) {
  TETLOOM_ASSERT(metric.size() == other.size());
  loop.for_blocks(metric.size(), kElementGrain, [&](std::size_t begin, std::size_t end) {
    for (std::size_t v = begin; v < end; ++v) {
      const Tensor a = metric.at(v), b = other.at(v), both = intersection(a, b);
      if (both == b)
        metric.logs[v] = other.logs[v];
      else if (both != a)
        metric.logs[v] = log(both);
    }
  });
}

}  // namespace tetloom::adapt
