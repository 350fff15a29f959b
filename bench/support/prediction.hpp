#pragma once
// What a recorded run of the volume stage would take on more threads than the machine has: predictions.
#include <span>
#include <string>
#include <vector>

#include "bench/support/svg_plot.hpp"
#include "threading/runtime/replay.hpp"

namespace tetloom::bench {

/// A stage that was recorded on one thread.
struct RecordedStage {
  std::vector<TaskRecord> records;
  double seconds = 0;  ///< of the stage as a whole

  /// What no record covers, which counts as serial.
  double serial_seconds() const;
};

struct Prediction {
  int workers = 1;
  double seconds = 0;
  double speedup = 1;      ///< over the same tasks on one worker
  double utilization = 1;  ///< share of the workers' time in which they carry out tasks
};

/// One per number of workers. Throws Error(InvalidArgument) like replay_tasks.
std::vector<Prediction> predict(const RecordedStage& stage, std::span<const int> workers, const MessageCosts& costs);

/// One line each.
void print_predictions(std::span<const Prediction> predictions);

/// "greedy list scheduling of the tasks recorded on one thread; ...": what must stand beside every prediction.
std::string describe_prediction(const MessageCosts& costs);

}  // namespace tetloom::bench
