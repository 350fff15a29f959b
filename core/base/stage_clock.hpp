#pragma once
// How long each stage of a run took, also of one that is still going on.
#include <array>
#include <cstddef>
#include <mutex>

#include "core/base/stopwatch.hpp"
#include "tetloom/host.hpp"

namespace tetloom {

/// Counts the wall time from `enter` to the next `enter` to the stage entered. Thread safety: all members may be called
/// from any thread.
class StageClock {
 public:
  /// Nothing happens when the stage is under way already.
  void enter(Stage stage) {
    const std::lock_guard lock(mutex_);
    if (entered_ && stage == stage_) return;
    count();
    stage_ = stage, entered_ = true;
  }
  /// So far; 0 for a stage that has not been entered.
  double seconds(Stage stage) const {
    const std::lock_guard lock(mutex_);
    count();
    return seconds_[static_cast<std::size_t>(stage)];
  }

 private:
  static constexpr std::size_t kStages = static_cast<std::size_t>(Stage::Write) + 1;

  void count() const {
    const double lap = watch_.lap();
    if (entered_) seconds_[static_cast<std::size_t>(stage_)] += lap;
  }

  mutable std::mutex mutex_;
  // Guarded by mutex_.
  mutable Stopwatch watch_;
  mutable std::array<double, kStages> seconds_{};
  Stage stage_ = Stage::Read;
  bool entered_ = false;
};

}  // namespace tetloom
