#pragma once
// How long the tasks of a trace would take on another number of threads: a prediction, not a measurement.
#include <span>

#include "tetloom/tasks.hpp"

namespace tetloom {

/// What the receiver of a message waits for after the sender's step has ended, if it is another part. The defaults are
/// of memory that threads share: waking a thread up, and copying on one core.
struct MessageCosts {
  static constexpr double kLatency = 5e-6;   ///< s
  static constexpr double kBandwidth = 5e9;  ///< bytes per second
  double latency = kLatency, bandwidth = kBandwidth;

  double seconds(std::uint64_t bytes) const { return latency + static_cast<double>(bytes) / bandwidth; }
};

/// The times of a replayed trace.
struct Replay {
  double seconds = 0;  ///< from the first start to the last end
  double work = 0;     ///< of all tasks, on one thread
};

/// Greedy list scheduling of the recorded tasks, each of which takes as long as it did: a worker that has nothing to do
/// begins the longest of the steps that wait for nothing any more (of equal ones the earliest step and lowest part). A
/// message to another part costs `costs`, wherever that part runs. Runs and work outside of schedules follow each
/// other by their numbers, with a barrier between them. Divisible work takes what all its threads spent on it over
/// pieces / ceil(pieces / workers). Steps whose sender has no record, as after an error, do not wait for it.
///
/// Where messages cost nothing the result is no longer than work / workers plus the longest chain. Threads that share
/// caches and memory slow each other down, which is no part of it: traces of one thread give what a machine could do
/// whose memory were never the limit. Costs O(n log n).
/// Errors: InvalidArgument for workers < 1, costs that are no times, records that end before they start, two records
/// for the same step of a part.
Replay replay_tasks(std::span<const TaskRecord> records, int workers, const MessageCosts& costs = {});

/// The seconds in which at least one of the records was under way. What a run took beyond that was not recorded.
double recorded_seconds(std::span<const TaskRecord> records);

}  // namespace tetloom
