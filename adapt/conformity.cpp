#include <algorithm>
#include <cmath>

#include "adapt/adapt.hpp"
#include "adapt/metric/vertex_metric.hpp"

namespace tetloom {

using namespace adapt;

MetricConformity measure_conformity(const Mesh& mesh, const MetricField& metric, const BlockLoop& loop) {
  constexpr std::size_t kGrain = std::size_t{1} << 12;
  std::vector<VertexMetric> metrics(mesh.points.size());
  loop.for_blocks(metrics.size(), kGrain, [&](std::size_t begin, std::size_t end) {
    for (std::size_t v = begin; v < end; ++v) {
      const Tensor tensor = exp(metric.logs[v]);
      metrics[v] = {tensor, det(tensor)};
    }
  });
  const VertexGraph graph(TetView{mesh.points, mesh.tet_to_vert}, loop);
  std::vector<MetricConformity> blocks((std::max(metrics.size(), mesh.tet_to_vert.size()) + kGrain - 1) / kGrain);
  for (MetricConformity& block : blocks) block.shortest = HUGE_VAL, block.least_quality = HUGE_VAL;
  loop.for_blocks(metrics.size(), kGrain, [&](std::size_t begin, std::size_t end) {
    MetricConformity& block = blocks[begin / kGrain];
    for (std::size_t a = begin; a < end; ++a) {
      for (const std::uint32_t b : graph.neighbors(a)) {
        if (b < a) continue;
        const double length = edge_length(metrics[a].tensor, metrics[b].tensor, mesh.points[b] - mesh.points[a]);
        ++block.edges;
        block.unit += length >= std::sqrt(0.5) && length <= std::sqrt(2.0);
        block.half_to_two += length >= 0.5 && length <= 2;
        block.shortest = std::min(block.shortest, length), block.longest = std::max(block.longest, length);
      }
    }
  });
  loop.for_blocks(mesh.tet_to_vert.size(), kGrain, [&](std::size_t begin, std::size_t end) {
    MetricConformity& block = blocks[begin / kGrain];
    for (std::size_t tet = begin; tet < end; ++tet) {
      // Metrics of sizes like 1e-60 overflow, and give what is not a number.
      const double cubed = cubed_mean_ratio(mesh.points, metrics, mesh.tet_to_vert[tet]);
      const double quality = cubed > 0 ? std::cbrt(std::min(cubed, 1.0)) : 0;
      block.least_quality = std::min(block.least_quality, quality), block.mean_quality += quality;
      ++block.quality_histogram[static_cast<std::size_t>(std::clamp(quality * 10, 0.0, 9.0))];
    }
  });
  MetricConformity all;
  all.shortest = HUGE_VAL, all.least_quality = HUGE_VAL;
  for (const MetricConformity& block : blocks) {
    all.edges += block.edges, all.unit += block.unit, all.half_to_two += block.half_to_two;
    all.shortest = std::min(all.shortest, block.shortest), all.longest = std::max(all.longest, block.longest);
    all.least_quality = std::min(all.least_quality, block.least_quality), all.mean_quality += block.mean_quality;
    for (std::size_t i = 0; i < 10; ++i) all.quality_histogram[i] += block.quality_histogram[i];
  }
  if (all.edges == 0) return MetricConformity();
  all.unit /= static_cast<double>(all.edges), all.half_to_two /= static_cast<double>(all.edges);
  all.mean_quality /= static_cast<double>(mesh.tet_to_vert.size());
  all.complexity = complexity(metric, TetView{mesh.points, mesh.tet_to_vert}, loop);
  return all;
}

}  // namespace tetloom
