#pragma once
// Gradation on a mesh of which this rank knows all neighbours of its own vertices.
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "tetloom/metric.hpp"

namespace tetloom::adapt {

/// Which of the vertices at hand are this rank's own, and how it hears of the others; by itself: all of them are.
struct OwnVerts {
  const std::vector<std::uint8_t>* is_own = nullptr;
  std::function<void(std::span<double>)> largest;  ///< over all ranks, in place
  /// Tells of own vertices whose metric has changed, and brings that of others; returns those.
  std::function<std::vector<std::uint32_t>(std::span<const std::uint32_t> changed, std::vector<Tensor>& logs)> refresh;

  bool has(std::size_t vert) const { return is_own == nullptr || (*is_own)[vert] != 0; }
};

/// As in metric.hpp, of all ranks together. Collective calls. Vertices ascend as in the whole mesh.
GradationResult limit_gradation(MetricField& metric, std::span<const Vec3> points, const VertexGraph& graph,
                                double growth, const OwnVerts& own, const BlockLoop& loop);

}  // namespace tetloom::adapt
