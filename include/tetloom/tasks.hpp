#pragma once
// Who carries out work: loops on threads, steps of parts, and records of what ran when.
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <mutex>
#include <span>
#include <string>
#include <vector>

#include "tetloom/assert.hpp"
#include "tetloom/communicator.hpp"
#include "tetloom/host.hpp"

// What ran when: one record per task, written in the trace event format that browsers' trace viewers open.

namespace tetloom {

/// What a recorded task was.
enum class TaskKind {
  Step,      ///< of a part, in a run of a schedule
  Serial,    ///< work outside of schedules, on one thread
  Divisible  ///< a parallel loop outside of schedules
};

/// "step", "serial" or "divisible".
const char* to_string(TaskKind kind);

/// The receiver and the size of a message.
struct SentMessage {
  PartId to;
  std::uint64_t bytes = 0;
};

/// What waits for what follows from the records: a part's next step of the same run for its step before and for all
/// those that sent to it; a run for the end of all runs of smaller numbers.
struct TaskRecord {
  PartId part;  ///< of a step
  std::uint32_t step = 0;
  std::string name;
  double start = 0, end = 0;  ///< seconds since the trace was made
  int worker = 0;             ///< index of the thread among those of the run
  TaskKind kind = TaskKind::Step;
  std::uint32_t run = 0;               ///< of a schedule; work outside of schedules has a number of its own
  std::vector<SentMessage> sent = {};  ///< one per receiver of a step, empty messages as well; ascending
  int threads = 1;                     ///< that shared divisible work
  std::uint64_t pieces = 0;            ///< of divisible work; 0: as many as there are threads

  double seconds() const { return end - start; }
  std::uint64_t bytes_sent() const;
};

/// Collects records of any number of schedules, one after the other. Thread-safe.
class Trace {
 public:
  Trace();
  double now() const;
  /// The number of the run that begins now, greater than all before.
  std::uint32_t begin_run();
  void add(TaskRecord record);
  /// Sorted by start.
  std::vector<TaskRecord> records() const;
  /// JSON in the trace event format (complete events; one row per thread). What a viewer does not need stands in
  /// "args": of a step "run", "part", "step", "bytes_sent" and "sent" ([part, bytes] of every message); of other work,
  /// by "cat", "run", "threads" and "pieces". Errors: OutputFailed.
  void write(const std::filesystem::path& file, int rank = 0) const;

 private:
  std::int64_t origin_nanoseconds_ = 0;
  mutable std::mutex mutex_;  // around what follows, once per task
  std::vector<TaskRecord> records_;
  std::uint32_t run_count_ = 0;
};

/// While it lives, this thread carries out a task that is recorded as a whole: loops that it begins leave no records.
class TracedTask {
 public:
  TracedTask();
  ~TracedTask();
  TracedTask(const TracedTask&) = delete;
  TracedTask& operator=(const TracedTask&) = delete;
  static bool is_inside();
};

/// Records work outside of schedules from its construction to its destruction; nothing where `trace` is null. No span
/// of a trace begins before another, or a run, has ended.
class TraceSpan {
 public:
  /// Serial work.
  TraceSpan(Trace* trace, std::string name);
  /// A loop over `pieces` (0: as many as one likes) that `threads` share.
  TraceSpan(Trace* trace, std::string name, int threads, std::uint64_t pieces = 0);
  ~TraceSpan();
  TraceSpan(const TraceSpan&) = delete;
  TraceSpan& operator=(const TraceSpan&) = delete;

 private:
  Trace* trace_;
  TaskRecord record_;
};

// Parallel loops, progress and cancellation of one run. oneTBB stays behind this header.

class Trace;

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

// The task graph: steps of parts, each run as soon as the messages that it waits for are there.

class Schedule;

/// Whether the calling thread is carrying out a step of any schedule.
bool inside_a_step();

/// The right to touch one part, for the duration of one step of it. Only a running Schedule makes one.
class PartTask {
 public:
  PartTask(const PartTask&) = delete;
  PartTask& operator=(const PartTask&) = delete;

  PartId part() const { return part_; }
  /// Non-empty messages for this step, ascending by sender. May be moved from: freeing them early saves memory.
  std::span<Message> inbox() { return inbox_; }
  /// To be delivered to the next step of `to`, which must be one of this step's receivers; at most one message each.
  void send(PartId to, Bytes bytes);
  /// Throws Error(Cancelled) once the run is cancelled, or when another part or rank has failed.
  void check_cancelled() const;
  /// For loops inside a part. While such a loop waits, its thread helps with this loop alone and begins no other step.
  const TaskRunner& runner() const;
  /// Whether this is the step that the calling thread is carrying out.
  bool is_current() const;

 private:
  friend class Schedule;
  PartTask(Schedule& schedule, PartId part, std::uint32_t step) : schedule_(schedule), part_(part), step_(step) {}
  Schedule& schedule_;
  PartId part_;
  std::uint32_t step_;
  std::vector<Message> inbox_;
  std::vector<Message> outbox_;
};

/// One value per part of this rank. A step reaches its own part's value alone, by its handle.
template <class T>
class PerPart {
 public:
  PerPart() = default;
  PerPart(std::size_t part_count, std::span<const PartId> local) : local_(local.begin(), local.end()) {
    first_ = local_.empty() ? 0 : local_.front().value;
    part_count_ = part_count;
    values_.resize(local_.size());
  }
  /// The number of parts on all ranks.
  std::size_t part_count() const { return part_count_; }
  /// Those of this rank, ascending and without gaps.
  std::span<const PartId> local() const { return local_; }
  bool is_local(PartId part) const { return part.value - first_ < values_.size() && part.value >= first_; }

  T& operator[](const PartTask& task) {
    TETLOOM_DEBUG_ASSERT(task.is_current());
    return values_[task.part().value - first_];
  }
  const T& operator[](const PartTask& task) const {
    TETLOOM_DEBUG_ASSERT(task.is_current());
    return values_[task.part().value - first_];
  }
  /// Outside of schedules only: a step that reaches for a part without its handle is caught in debug builds.
  T& at(PartId part) {
    TETLOOM_DEBUG_ASSERT(!inside_a_step());
    TETLOOM_ASSERT(is_local(part));
    return values_[part.value - first_];
  }
  const T& at(PartId part) const { return const_cast<PerPart*>(this)->at(part); }

 private:
  std::vector<PartId> local_;
  std::uint32_t first_ = 0;
  std::size_t part_count_ = 0;
  std::vector<T> values_;
};

/// Who a step's messages may go to, for each part of this rank, and who the next step hears from. Both sides must
/// agree: q is among the receivers of p exactly when p is among the senders of q.
struct Links {
  std::function<std::span<const PartId>(PartId)> receivers;  ///< ascending; of a part of this rank
  std::function<std::span<const PartId>(PartId)> senders;    ///< ascending; of a part of this rank
};

/// Links between neighbours, where hearing and being heard are the same relation.
Links neighbour_links(std::function<std::span<const PartId>(PartId)> neighbours);

/// Links from receivers alone; a collective call that finds the senders. `receivers` must outlive the result.
Links directed_links(Communicator& communicator, const PerPart<std::vector<PartId>>& receivers);

/// What every part does once in a run of a schedule.
struct Step {
  std::string name;  ///< for traces
  std::function<void(PartTask&)> body;
  Links links;                         ///< of the messages that this step sends; empty: it sends none
  std::function<double(PartId)> work;  ///< estimate, in any unit; larger starts earlier. Empty: all alike
};

/// Runs steps in order on every part of all ranks. A part's step k + 1 starts when its own step k is over and every
/// sender of step k's links has been heard (an empty message counts): there is no barrier between steps, and no step
/// of a part runs beside another of the same part.
///
/// A oneTBB flow graph with one node per part and step. Errors, the same on all ranks: what a body throws, as an Error:
/// OutOfMemory for lack of memory, Internal for what is none (of several, the one of the earliest step and lowest part
/// of the lowest rank where one threw); Error(Cancelled) after a host's cancel. After an error no body is running any
/// more, undelivered messages are dropped, and the schedule can be run again. Bodies that must not be torn apart are
/// written to leave their part consistent when they throw. Cancellation is seen between steps, and inside bodies where
/// they ask.
class Schedule {
 public:
  /// All must outlive the schedule. `trace` may be null.
  Schedule(Communicator& communicator, const TaskRunner& runner, std::size_t part_count, Trace* trace = nullptr);
  ~Schedule();

  std::span<const PartId> local_parts() const;
  /// All ranks run the same steps. `uninterruptible`: the host's cancel is not heard during the run, nor by the loops
  /// of PartTask::runner(); whatever asks next after the run hears of it.
  void run(std::span<const Step> steps, bool uninterruptible = false);

 private:
  friend class PartTask;
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace tetloom
