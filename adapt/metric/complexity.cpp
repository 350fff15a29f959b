// The number of elements that a metric asks for.
#include <algorithm>

#include "adapt/metric/own_hessian.hpp"
#include "adapt/metric/own_tets.hpp"
#include "core/base/grain.hpp"
#include "tetloom/assert.hpp"
#include "tetloom/metric.hpp"

namespace tetloom::adapt {
namespace {

/// The exact sum of the terms from `first` on.
template <class TermOf>
ExactSum sum_of(std::size_t first, std::size_t count, const BlockLoop& loop, const TermOf& term_of) {
  ExactSum total;
  for (const ExactSum& sum :
       map_blocks(loop, count, kElementGrain, ExactSum(), [&](std::size_t begin, std::size_t end, ExactSum&of_block) {
         for (std::size_t i = begin; i < end; ++i) of_block.add(term_of(first + i));
       }))
    total.add(sum);
  return total;
}

double volume_of(const TetView& mesh, const TetVerts& tet) {
  const Vec3& a = mesh.points[tet[0]];
  return std::abs(dot(cross(mesh.points[tet[1]] - a, mesh.points[tet[2]] - a), mesh.points[tet[3]] - a)) / 6;
}

/// A quarter of the volume around each vertex: the complexity is a weighted sum over vertices.
std::vector<double> vertex_volumes(const TetView& mesh) {
  std::vector<double> volumes(mesh.points.size());
  for (const TetVerts& tet : mesh.tets) {
    const double quarter = volume_of(mesh, tet) / 4;
    for (const std::uint32_t v : tet) volumes[v] += quarter;
  }
  return volumes;
}

/// Logarithms of eigenvalues, ascending: all that bounds and the complexity depend on.
using Spectrum = std::array<double, 3>;

Spectrum bounded(Spectrum values, double shift, const MetricBounds& bounds) {
  const double most = bounds.h_min > 0 ? -2 * std::log(bounds.h_min) : HUGE_VAL;
  const double least = -2 * std::log(bounds.h_max);
  for (double& value : values) value = std::clamp(value + shift, least, most);
  const double by_aspect = values[2] - 2 * std::log(bounds.max_aspect);
  for (double& value : values) value = std::max(value, by_aspect);
  return values;
}

}  // namespace

double complexity(const MetricField& metric, const TetView& mesh, const BlockLoop& loop) {
  return complexity(metric, mesh, OwnTets(), loop);
}

double complexity(const MetricField& metric, const TetView& mesh, const OwnTets& own, const BlockLoop& loop) {
  TETLOOM_ASSERT(metric.size() == mesh.points.size());
  std::vector<double> densities(metric.size());
  loop.for_blocks(metric.size(), kElementGrain, [&](std::size_t begin, std::size_t end) {
    for (std::size_t v = begin; v < end; ++v) densities[v] = std::exp(0.5 * trace(metric.logs[v]));
  });
  ExactSum sum = sum_of(own.first(), own.count_of(mesh.tets.size()), loop, [&](std::size_t t) {
    const TetVerts& tet = mesh.tets[t];
    return volume_of(mesh, tet) / 4 *
           ((densities[tet[0]] + densities[tet[1]]) + (densities[tet[2]] + densities[tet[3]]));
  });
  own.add_up(sum);
  return sum.value();
}

double scale_to_complexity(MetricField& metric, const TetView& mesh, double target, const MetricBounds& bounds,
                           const BlockLoop& loop) {
  return scale_to_complexity(metric, mesh, target, bounds, OwnMesh(), loop);
}

double scale_to_complexity(MetricField& metric, const TetView& mesh, double target, const MetricBounds& bounds,
                           const OwnMesh& own, const BlockLoop& loop) {
  TETLOOM_ASSERT(metric.size() == mesh.points.size() && target > 0);
  require_valid(bounds);
  const std::vector<double> volumes = vertex_volumes(mesh);
  std::vector<Spectrum> spectra(metric.size());
  loop.for_blocks(metric.size(), kElementGrain, [&](std::size_t begin, std::size_t end) {
    for (std::size_t v = begin; v < end; ++v) spectra[v] = eigen(metric.logs[v]).values;
  });
  const auto complexity_at = [&](double shift) {
    const auto term_of = [&](std::size_t v) {
      if (!own.counts(v)) return 0.0;
      const Spectrum s = bounded(spectra[v], shift, bounds);
      return volumes[v] * std::exp(0.5 * (s[0] + s[1] + s[2]));
    };
    ExactSum sum = sum_of(0, spectra.size(), loop, term_of);
    own.tets.add_up(sum);
    return sum.value();
  };
  // The complexity grows with the shift s as exp(3 s / 2) where nothing is bounded, more slowly where something is.
  constexpr int kMostSteps = 60;
  double shift = 0, low = -HUGE_VAL, high = HUGE_VAL;
  for (int step = 0; step < kMostSteps; ++step) {
    const double ratio = target / complexity_at(shift);
    if (std::abs(ratio - 1) < 1e-7) break;
    (ratio > 1 ? low : high) = shift;
    const double next = shift + std::log(ratio) / 1.5;
    if (next > low && next < high && step < kMostSteps / 2)
      shift = next;
    else if (std::isfinite(low) && std::isfinite(high))
      shift = 0.5 * (low + high);
    else
      shift = next;
  }
  loop.for_blocks(metric.size(), kElementGrain, [&](std::size_t begin, std::size_t end) {
    for (std::size_t v = begin; v < end; ++v)
      metric.logs[v] = bounded_log(metric.logs[v] + diagonal(shift, shift, shift), bounds);
  });
  return complexity(metric, mesh, own.tets, loop);
}

}  // namespace tetloom::adapt
