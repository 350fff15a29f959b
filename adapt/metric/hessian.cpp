#include "tetloom/metric.hpp"

#include <algorithm>
#include <array>
#include <string>

#include "adapt/metric/own_hessian.hpp"
#include "core/base/grain.hpp"
#include "tetloom/error.hpp"

namespace tetloom::adapt {
namespace {

/// Eigenvalues below this part of the largest one of all vertices count as this part.
constexpr double kSmallest = 1e-14;
constexpr double kComplexityTolerance = 0.01;
constexpr int kMostScalings = 12;

void require_valid(const HessianOptions& options) {
  if (!(options.complexity > 0) || !std::isfinite(options.complexity))
    throw Error(ErrorCode::InvalidArgument, "the complexity must be positive");
  if (!(options.norm >= 1)) throw Error(ErrorCode::InvalidArgument, "the norm must be at least 1");
  if (options.gradation != 0 && !(options.gradation > 1 && std::isfinite(options.gradation)))
    throw Error(ErrorCode::InvalidArgument, "the gradation must be larger than 1, or 0 for none");
  require_valid(options.bounds);
}

double largest_curvature(std::span<const Tensor> hessians, const BlockLoop& loop) {
  const auto largest =
      map_blocks(loop, hessians.size(), kElementGrain, 0.0, [&](std::size_t begin, std::size_t end, double& of_block) {
        for (std::size_t v = begin; v < end; ++v) {
          const EigenSystem e = eigen(hessians[v]);
          of_block = std::max({of_block, std::abs(e.values[0]), std::abs(e.values[2])});
        }
      });
  return largest.empty() ? 0 : *std::max_element(largest.begin(), largest.end());
}

/// The logarithm of det^(-1 / (2p + 3)) |H|.
Tensor normalised_log(const Tensor& hessian, double least, double norm) {
  const Tensor logarithm =
      map_eigenvalues(hessian, [&](double value) { return std::log(std::max(std::abs(value), least)); });
  const double shift = -trace(logarithm) / (2 * norm + 3);
  return logarithm + diagonal(shift, shift, shift);
}

}  // namespace

double diagonal_of(std::span<const Vec3> points, const OwnTets& own) {
  const Box3 box = box_of(points);
  std::array<double, 6> ends{-box.lo.x, -box.lo.y, -box.lo.z, box.hi.x, box.hi.y, box.hi.z};
  if (own.largest) own.largest(ends);
  return norm(Vec3{ends[3] + ends[0], ends[4] + ends[1], ends[5] + ends[2]});
}

double flat_curvature(double low, double high, double diagonal) {
  constexpr double kFlat = 1e-9;
  return kFlat * (high - low) / (diagonal * diagonal);
}

HessianMetric metric_from_hessian(std::span<const Tensor> hessians, double flat, const TetView& mesh,
                                  const VertexGraph& graph, const HessianOptions& options, const BlockLoop& loop) {
  return metric_from_hessian(hessians, flat, mesh, graph, options, OwnMesh(), loop);
}

HessianMetric metric_from_hessian(std::span<const Tensor> hessians, double flat, const TetView& mesh,
                                  const VertexGraph& graph, const HessianOptions& options, const OwnMesh& own,
                                  const BlockLoop& loop) {
  require_valid(options);
  if (hessians.size() != mesh.points.size())
    throw Error(ErrorCode::InvalidArgument, std::to_string(hessians.size()) + " Hessians do not fit " +
                                                std::to_string(mesh.points.size()) + " vertices");
  const double largest = own.tets.largest_of(largest_curvature(hessians, loop));
  if (!(largest > flat))
    throw Error(ErrorCode::InputUnsuitable, "the field has no curvature that a mesh could be adapted to");
  MetricField base;
  base.logs.resize(hessians.size());
  loop.for_blocks(hessians.size(), kElementGrain, [&](std::size_t begin, std::size_t end) {
    for (std::size_t v = begin; v < end; ++v)
      base.logs[v] = normalised_log(hessians[v], largest * kSmallest, options.norm);
  });
  MetricBounds bounds = options.bounds;
  bounds.h_max = std::max(bounds.h_min, std::min(bounds.h_max, diagonal_of(mesh.points, own.tets)));
  double goal = options.complexity;
  for (int scaling = 0;; ++scaling) {
    HessianMetric result{base, 0};
    result.complexity = scale_to_complexity(result.metric, mesh, goal, bounds, own, loop);
    if (options.gradation > 0) limit_gradation(result.metric, mesh.points, graph, options.gradation, own.verts, loop);
    const bool turns = limit_turning(result.metric, mesh, own.tets, loop).turns;
    if (turns) apply_bounds(result.metric, bounds, loop);
    if (scaling == 0 && options.gradation == 0 && !turns) return result;
    result.complexity = complexity(result.metric, mesh, own.tets, loop);
    const double ratio = options.complexity / result.complexity;
    if (std::abs(ratio - 1) <= kComplexityTolerance || scaling == kMostScalings) {
      // The little that is missing makes no turn too fast; gradation would no longer be as asked.
      if (options.gradation == 0)
        result.complexity = scale_to_complexity(result.metric, mesh, options.complexity, bounds, own, loop);
      return result;
    }
    goal *= ratio;  // what limits add is about the same share again
  }
}

HessianMetric metric_from_solution(std::span<const double> values, const TetView& mesh, const HessianOptions& options,
                                   const BlockLoop& loop) {
  require_valid(options);
  const VertexGraph graph(mesh, loop);
  const std::vector<Tensor> hessians = recover_hessian(values, mesh, graph, loop);
  if (values.empty()) throw Error(ErrorCode::InputUnsuitable, "the mesh has no vertices");
  const auto [low, high] = std::minmax_element(values.begin(), values.end());
  const double flat = flat_curvature(*low, *high, diagonal_of(mesh.points, OwnTets()));
  return metric_from_hessian(hessians, flat, mesh, graph, options, loop);
}

}  // namespace tetloom::adapt
