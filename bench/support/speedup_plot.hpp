#pragma once
// What plots and files of speed-ups by threads have in common.
#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <vector>

#include "bench/support/prediction.hpp"
#include "bench/support/svg_plot.hpp"

namespace tetloom::bench {

/// Logarithmic, with a tick for each count.
Axis thread_axis(std::span<const int> counts, const char* label);

/// As many times as fast as there are threads.
PlotSeries ideal_speedup(std::span<const int> counts);

/// Predictions, beside what was `measured`: (threads, times as fast). `what` says of what they are.
Panel prediction_panel(const std::string& title, const std::string& what, std::span<const Prediction> predictions,
                       std::vector<PlotPoint> measured);

/// How a recorded run was, and what follows from it.
nlohmann::json predictions_json(const RecordedStage& stage, std::span<const Prediction> predictions);

}  // namespace tetloom::bench
