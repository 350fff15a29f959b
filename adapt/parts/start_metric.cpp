#include "adapt/parts/start_metric.hpp"

#include <algorithm>
#include <array>

#include "core/base/grain.hpp"

namespace tetloom::adapt {

FirstStage set_start_metric(WholeMesh& share, const GivenMetric& given, const MetricFunction& function,
                            const SharedWork& work) {
  const std::size_t count = share.points.size();
  std::array<double, 1> most{0};
  work.each([&] {
    const auto blocks = map_blocks(work.runner(), count, kElementGrain, 0.0,
                                   [&](std::size_t begin, std::size_t end, double& refinement) {
                                     for (std::size_t v = begin; v < end; ++v) {
                                       const std::uint32_t at = given.given_of(static_cast<std::uint32_t>(v));
                                       if (at == kNone) continue;
                                       const Tensor asked = function ? function(share.points[v]) : exp(given.logs[at]);
                                       share.to_metric[v].tensor = asked;
                                       refinement = std::max(refinement, refinement_of(asked, given.implied[at]));
                                     }
                                   });
    for (const double refinement : blocks) most[0] = std::max(most[0], refinement);
  });
  work.max(most);
  const FirstStage stage{most[0], most[0] <= kFirstRatio ? HUGE_VAL : kFirstRatio};
  work.each([&] {
    work.runner().for_blocks(count, kElementGrain, [&](std::size_t begin, std::size_t end) {
      for (std::size_t v = begin; v < end; ++v) {
        const std::uint32_t at = given.given_of(static_cast<std::uint32_t>(v));
        if (at == kNone) continue;
        VertexMetric& metric = share.to_metric[v];
        metric.tensor = limited(metric.tensor, given.implied[at], stage.ratio);
        metric.det = det(metric.tensor);
      }
    });
  });
  return stage;
}

}  // namespace tetloom::adapt
