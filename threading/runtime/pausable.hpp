#pragma once
// Work that stops in the middle, and goes on there later.
#include <condition_variable>
#include <exception>
#include <functional>
#include <mutex>
#include <thread>
#include <utility>

namespace tetloom {

/// Work on a thread of its own, beside which the caller waits until it ends or pauses. So it can lack something deep
/// inside, have the caller fetch that, and go on as if it had been there, without a copy to begin anew from.
///
/// The work may not use loops of a TaskRunner: a caller that waits is one of its threads. Thread safety: one caller at
/// a time.
class Pausable {
 public:
  explicit Pausable(std::function<void()> work) : work_(std::move(work)) {}
  /// Work that has paused is left: what it paused in throws there.
  ~Pausable();
  Pausable(const Pausable&) = delete;
  Pausable& operator=(const Pausable&) = delete;

  /// Lets the work begin, or go on, until it ends or pauses; whether it has ended. Errors: what the work throws.
  bool resume();

  /// Whether this thread does such work.
  static bool is_here() { return here_ != nullptr; }
  /// In the work: waits until it is resumed. Pre: is_here().
  static void pause();

  /// Processor time that this thread has taken, and work on other threads that it has resumed. Seconds.
  static double processor_seconds();

 private:
  struct Left {};  // thrown out of work that is not resumed

  void run() noexcept;

  static thread_local Pausable* here_;
  std::function<void()> work_;
  std::thread thread_;
  std::mutex mutex_;  // around what follows
  std::condition_variable changed_;
  bool works_ = false, ended_ = false, left_ = false;
  double seconds_ = 0;  // that the work has taken
  std::exception_ptr error_;
};

}  // namespace tetloom
