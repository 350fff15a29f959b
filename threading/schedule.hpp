#pragma once
// The task graph: steps of parts, each run as soon as the messages that it waits for are there.
#include <cstddef>
#include <filesystem>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "core/base/assert.hpp"
#include "threading/communicator.hpp"
#include "threading/task_runner.hpp"
#include "threading/trace.hpp"

namespace tetloom {

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
/// A oneTBB flow graph with one node per part and step. Errors, the same on all ranks: what a body throws (of several,
/// the one of the earliest step and lowest part of the lowest rank where one threw; between ranks it travels as an
/// Error), Error(Cancelled) after a host's cancel. After an error no body is running any more, undelivered messages are
/// dropped, and the schedule can be run again. Bodies that must not be torn apart are written to leave their part
/// consistent when they throw. Cancellation is seen between steps, and inside bodies where they ask.
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
