#include "tetloom/tasks.hpp"

#include <utility>

#include "threading/comm/schedule_state_detail.hpp"

namespace tetloom {

namespace {

thread_local const PartTask* current_task = nullptr;

}  // namespace

detail::CurrentTask::CurrentTask(const PartTask& task) : before_(std::exchange(current_task, &task)) {}
detail::CurrentTask::~CurrentTask() { current_task = before_; }

bool inside_a_step() { return current_task != nullptr; }

bool PartTask::is_current() const { return current_task == this; }

void PartTask::send(PartId to, Bytes bytes) { schedule_.state_->run->put_in_outbox(*this, to, std::move(bytes)); }

void PartTask::check_cancelled() const { schedule_.state_->run->check_cancelled(); }

const TaskRunner& PartTask::runner() const { return schedule_.state_->run->runner(); }

Schedule::Schedule(Communicator& communicator, const TaskRunner& runner, std::size_t part_count, Trace* trace)
    : state_(new State{communicator, runner, runner.uninterruptible(), part_count, trace,
                       communicator.parts_of_rank(part_count)}) {}

Schedule::~Schedule() = default;

std::span<const PartId> Schedule::local_parts() const { return state_->local; }

void Schedule::run(std::span<const Step> steps, bool uninterruptible) {
  TETLOOM_ASSERT(!inside_a_step() && !state_->run);
  State::Run run(*this, steps, uninterruptible);
  state_->run = &run;
  try {
    run.carry_out();
  } catch (...) {
    state_->run = nullptr;
    throw;
  }
  state_->run = nullptr;
}

}  // namespace tetloom
