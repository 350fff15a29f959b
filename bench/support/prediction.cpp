#include "bench/support/prediction.hpp"

#include <algorithm>
#include <cstdio>

namespace tetloom::bench {

double RecordedStage::serial_seconds() const { return std::max(0.0, seconds - recorded_seconds(records)); }

std::vector<Prediction> predict(const RecordedStage& stage, std::span<const int> workers, const MessageCosts& costs) {
  const double serial = stage.serial_seconds();
  const double alone = serial + replay_tasks(stage.records, 1, costs).seconds;
  std::vector<Prediction> predictions;
  for (const int count : workers) {
    const Replay replay = replay_tasks(stage.records, count, costs);
    const double seconds = serial + replay.seconds;
    Prediction prediction{count, seconds, 1, 1};
    if (seconds > 0) {
      prediction.speedup = alone / seconds;
      prediction.utilization = (serial + replay.work) / (count * seconds);
    }
    predictions.push_back(prediction);
  }
  return predictions;
}

void print_predictions(std::span<const Prediction> predictions) {
  for (const Prediction& one : predictions)
    std::printf("  %3d workers: %9.3f s, %6.2f times as fast as 1, %5.1f %% busy (prediction)\n", one.workers,
                one.seconds, one.speedup, 100 * one.utilization);
}

std::string describe_prediction(const MessageCosts& costs) {
  char text[400];
  std::snprintf(text, sizeof(text),
                "Prediction, not a measurement: greedy list scheduling of the tasks recorded on 1 thread, each as long "
                "as it was there; a message to another part takes %g us and its bytes over %g GB/s; what was not "
                "recorded counts as serial; threads do not slow each other down.",
                1e6 * costs.latency, 1e-9 * costs.bandwidth);
  return text;
}

}  // namespace tetloom::bench
