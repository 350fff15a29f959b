#pragma once
// Parallel loops, progress and cancellation of one run. oneTBB stays behind this header.
#include <cstddef>
#include <functional>
#include <memory>
#include <span>

#include "core/base/block_loop.hpp"
#include "core/base/progress.hpp"

namespace tetloom {

class Trace;

/// What a host hands to a long-running call.
struct Host {
  ProgressCallback progress;            ///< may be empty
  const CancelToken* cancel = nullptr;  ///< may be null
  /// Asked wherever the call looks whether to go on: true ends it, like the token. Called from any thread, by several
  /// at once; it must be quick and must not throw. May be empty.
  std::function<bool()> wants_stop = {};
};

/// Runs the parallel loops of one call on a fixed number of threads, tells the host of progress and stops when it asks.
/// All members may be called from inside loop bodies, including the loops themselves (nested loops share the threads).
/// The order in which bodies run is not defined: results must not depend on it.
class TaskRunner : public BlockLoop {
 public:
  /// Pre: threads >= 1, or 0 for all cores that the process may use. `trace` takes what loops did that are no part of
  /// another task: every item of loops over items as a step, as if each were a part; loops over blocks as divisible
  /// work. May be null; else it outlives the runner and its copies.
  explicit TaskRunner(int threads, Host host = {}, Trace* trace = nullptr);
  ~TaskRunner() override;
  TaskRunner(const TaskRunner&) = delete;
  TaskRunner& operator=(const TaskRunner&) = delete;

  int threads() const;

  /// Calls body(i) for 0 <= i < count, one item per task. An exception of a body ends the loop and reaches the
  /// caller; bodies already running are finished first. Throws Error(Cancelled) once the run is cancelled.
  void for_each(std::size_t count, const std::function<void(std::size_t)>& body) const;
  /// The same in blocks [begin, end) of at most `grain` items, cut at multiples of `grain` whatever the threads.
  void for_blocks(std::size_t count, std::size_t grain,
                  const std::function<void(std::size_t, std::size_t)>& body) const override;
  /// The same for items of known estimated work, largest first, so that no big one is left to the end.
  void for_each_largest_first(std::span<const double> work, const std::function<void(std::size_t)>& body) const;

  /// Starts a stage of `total` units (0: unknown) and reports it.
  void begin_stage(Stage stage, std::uint64_t total) const;
  /// Adds to what is done of the current stage; the host hears of it at most every few milliseconds.
  void advance(std::uint64_t amount = 1, ModelEntity entity = {}) const;
  bool cancelled() const;
  /// Throws Error(Cancelled) when cancelled. Bodies longer than a few milliseconds call it now and then.
  void check_cancelled() const;
  /// The same threads and progress, deaf to the host's wish to stop: for what must not be torn apart.
  TaskRunner uninterruptible() const;
  /// The same progress and cancellation on `factor` times the threads, for a while in which the others' owners are
  /// idle; no more than the cores that the process may use, and never fewer than before. Pre: factor >= 1.
  TaskRunner with_idle_threads(int factor) const;

 private:
  friend class Schedule;
  struct Threads;
  struct Ties;
  TaskRunner(std::shared_ptr<Threads> threads, std::shared_ptr<Ties> ties, bool hears_cancel);

  /// Carries out `call` on the calling thread as one of the runner's threads: what it hands to oneTBB stays with them.
  void execute(const std::function<void()>& call) const;
  void run_blocks(std::size_t count, std::size_t grain,
                  const std::function<void(std::size_t, std::size_t)>& body) const;
  void run_recorded_items(std::size_t count, const std::function<void(std::size_t, std::size_t)>& body,
                          Trace& trace) const;
  std::shared_ptr<Threads> threads_;
  std::shared_ptr<Ties> ties_;
  bool hears_cancel_ = true;
};

}  // namespace tetloom
