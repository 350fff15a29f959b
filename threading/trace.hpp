#pragma once
// What ran when: one record per task, written in the trace event format that browsers' trace viewers open.
#include <cstdint>
#include <filesystem>
#include <mutex>
#include <string>
#include <vector>

#include "threading/message.hpp"

namespace tetloom {

enum class TaskKind {
  Step,      ///< of a part, in a run of a schedule
  Serial,    ///< work outside of schedules, on one thread
  Divisible  ///< a parallel loop outside of schedules
};

/// "step", "serial" or "divisible".
const char* to_string(TaskKind kind);

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

}  // namespace tetloom
