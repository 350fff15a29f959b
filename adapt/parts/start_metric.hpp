#pragma once
// The metric at vertices before the first round.
#include <cmath>
#include <cstdint>
#include <functional>
#include <span>

#include "adapt/kernel/metric_stage.hpp"
#include "adapt/parts/whole_mesh.hpp"
#include "threading/comm/shared_work.hpp"

namespace tetloom::adapt {

/// What is known where the vertices of a share are. They are those of the mesh that was given, so that nothing has to
/// be looked up in the background.
struct GivenMetric {
  std::span<const Tensor> logs;     ///< of the metric asked for, at given vertices; not used where there is a function
  std::span<const Tensor> implied;  ///< logarithms, at given vertices; see ImpliedMetric
  std::function<std::uint32_t(std::uint32_t)> given_of;  ///< the given vertex that one of the share is; kNone: no tet's
};

/// The first stage.
struct FirstStage {
  double refinement = 0;    ///< the largest ratio of sizes of the mesh to those asked for, over all ranks
  double ratio = HUGE_VAL;  ///< of the stage; see MetricStage
};

/// The least ratio of sizes that is worth a stage of its own.
inline constexpr double kFirstRatio = 2;

/// Sets the metric of the share's vertices to that of the first stage. In SharedWork::together.
FirstStage set_start_metric(WholeMesh& share, const GivenMetric& given, const MetricFunction& function,
                            const SharedWork& work);

}  // namespace tetloom::adapt
