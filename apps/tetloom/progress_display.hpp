#pragma once
// Progress on a terminal or in a log.
#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <cstdio>
#include <mutex>
#include <string>
#include <thread>

#include "tetloom/host.hpp"

namespace tetloom::app {

/// Where a stage is.
struct StageProgress {
  Stage stage = Stage::Read;
  std::uint64_t done = 0;
  std::uint64_t total = 0;  ///< 0: unknown
  double seconds = 0;       ///< since the stage began
};

/// One line of at most `width` columns: stage, bar, what is done, rate, remaining time. Without a newline.
std::string render_bar(const StageProgress& progress, int width);

/// The same as plain words, for logs: "faces: 12 of 40, 5.1/s, 6 s left".
std::string render_line(const StageProgress& progress);

/// Draws progress from a thread of its own, so that reporting it costs next to nothing and the display lives while a
/// stage is silent. A terminal gets a bar, redrawn ten times per second; anything else gets plain lines: one when a
/// stage begins, and one every two seconds while it lasts.
/// Thread safety: all members may be called from any thread.
class ProgressDisplay {
 public:
  enum class Style { Silent, Lines, Bar };
  /// Bar on a terminal, Lines elsewhere, Silent when quiet.
  static Style style_for(std::FILE* stream, bool quiet);

  ProgressDisplay(std::FILE* stream, Style style);
  ~ProgressDisplay();
  ProgressDisplay(const ProgressDisplay&) = delete;
  ProgressDisplay& operator=(const ProgressDisplay&) = delete;

  void update(const ProgressEvent& event);
  /// Removes the bar and draws no more. May be called more than once.
  void finish();

 private:
  using Clock = std::chrono::steady_clock;

  void run();
  void draw();
  void draw_bar(const StageProgress& progress);
  void draw_line(const StageProgress& progress, bool new_stage);

  std::FILE* stream_;
  const Style style_;
  std::mutex mutex_;
  std::condition_variable changed_;
  // Guarded by mutex_.
  StageProgress progress_;
  Clock::time_point stage_start_;
  unsigned stages_begun_ = 0;
  bool finished_ = false;
  // Only used by the drawing thread.
  unsigned stages_drawn_ = 0;
  unsigned stages_announced_ = 0;  // bits by Stage
  Clock::time_point last_line_;
  bool bar_visible_ = false;
  std::thread thread_;
};

}  // namespace tetloom::app
