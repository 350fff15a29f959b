#include "bench/support/speedup_plot.hpp"

#include <utility>

namespace tetloom::bench {

Axis thread_axis(std::span<const int> counts, const char* label) {
  Axis axis{label, Scale::Log};
  for (const int count : counts) axis.ticks.push_back({static_cast<double>(count), std::to_string(count)});
  return axis;
}

PlotSeries ideal_speedup(std::span<const int> counts) {
  PlotSeries series{"ideal", {}, Stroke::Dashed, false};
  for (const int count : counts) series.points.push_back({static_cast<double>(count), static_cast<double>(count)});
  return series;
}

Panel prediction_panel(const std::string& title, const std::string& what, std::span<const Prediction> predictions,
                       std::vector<PlotPoint> measured) {
  std::vector<int> workers;
  PlotSeries predicted{what + ", PREDICTED", {}};
  for (const Prediction& prediction : predictions) {
    workers.push_back(prediction.workers);
    predicted.points.push_back({static_cast<double>(prediction.workers), prediction.speedup});
  }
  return {title,
          thread_axis(workers, "threads"),
          {"times as fast as on 1 thread", Scale::Log},
          {std::move(predicted), {what + ", measured", std::move(measured), Stroke::None}, ideal_speedup(workers)}};
}

nlohmann::json predictions_json(const RecordedStage& stage, std::span<const Prediction> predictions) {
  nlohmann::json list = nlohmann::json::array();
  for (const Prediction& one : predictions)
    list.push_back({{"workers", one.workers},
                    {"predicted_seconds", one.seconds},
                    {"predicted_speedup", one.speedup},
                    {"predicted_utilization", one.utilization}});
  return {{"tasks", stage.records.size()},
          {"recorded_run_seconds", stage.seconds},
          {"not_recorded_seconds", stage.serial_seconds()},
          {"predictions", list}};
}

}  // namespace tetloom::bench
