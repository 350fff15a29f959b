#include <oneapi/tbb/task_arena.h>

#include <algorithm>
#include <numeric>
#include <utility>

#include "tetloom/tasks.hpp"
#include "threading/comm/collectives.hpp"
#include "threading/comm/schedule_state_detail.hpp"

namespace tetloom {

namespace tbb = oneapi::tbb;
using Priorities = std::vector<tbb::flow::node_priority_t>;

bool detail::is_cancellation(const std::exception_ptr& error) {
  try {
    std::rethrow_exception(error);
  } catch (const Error& caught) {
    return caught.code() == ErrorCode::Cancelled;
  } catch (...) {
    return false;
  }
}

void detail::FirstError::add(std::uint32_t step, PartId part, std::exception_ptr error) {
  const Key key{is_cancellation(error), step, part};
  const std::lock_guard lock(mutex_);
  if (error_ && key_ <= key) return;
  key_ = key;
  error_ = std::move(error);
}

Schedule::State::Run::Run(Schedule& schedule, std::span<const Step> steps, bool uninterruptible)
    : schedule_(schedule),
      state_(*schedule.state_),
      steps_(steps),
      uninterruptible_(uninterruptible),
      trace_run_(state_.trace ? state_.trace->begin_run() : 0) {}

void Schedule::State::Run::carry_out() {
  prepare();
  state_.runner.execute([&] { run_graph(); });
  report();
}

// What fails on one rank must end the run on all: each takes part in the sum.
void Schedule::State::Run::prepare() {
  std::exception_ptr error;
  std::int64_t sums[2] = {0, 0};
  try {
    make_tables();
    sums[0] = static_cast<std::int64_t>(link_imbalance());
  } catch (...) {
    error = std::current_exception();
    sums[1] = 1;
  }
  state_.communicator.sum(sums);
  if (sums[1] != 0) fail_together(error);
  if (sums[0] != 0) throw Error(ErrorCode::Internal, "broken invariant: receivers and senders of a step disagree");
}

// Throws what the lowest rank gives that gives an error; all ranks call it, and one of them gives one.
void Schedule::State::Run::fail_together(const std::exception_ptr& error) const {
  agree(state_.communicator, error ? failure_of([&] { std::rethrow_exception(error); }) : std::nullopt);
}

void Schedule::State::Run::make_tables() {
  const auto& local = state_.local;
  for (std::uint32_t step = 0; step < steps_.size(); ++step) {
    const auto receivers = is_last(step) ? detail::LinkTable::ListOf{} : steps_[step].links.receivers;
    const auto senders = step == 0 ? detail::LinkTable::ListOf{} : steps_[step - 1].links.senders;
    tables_.push_back({{local, receivers, state_.part_count}, {local, senders, state_.part_count}, {}, {}});
    tables_.back().arrived.resize(tables_.back().senders.size());
    tables_.back().priorities = rank_by_work(steps_[step]);
  }
}

std::uint64_t Schedule::State::Run::link_imbalance() const {
  std::uint64_t sum = 0;
  for (std::size_t step = 0; step < steps_.size(); ++step)
    for (std::size_t local = 0; local < state_.local.size(); ++local) {
      const PartId part = state_.local[local];
      for (const PartId to : tables_[step].receivers.of(local)) sum += detail::link_hash(step + 1, part, to);
      for (const PartId from : tables_[step].senders.of(local)) sum -= detail::link_hash(step, from, part);
    }
  return sum;
}

Priorities Schedule::State::Run::rank_by_work(const Step& step) const {
  const std::size_t count = state_.local.size();
  std::vector<double> work(count, 0.0);
  if (step.work) std::transform(state_.local.begin(), state_.local.end(), work.begin(), step.work);
  std::vector<std::size_t> order(count);
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return work[a] > work[b]; });
  Priorities priorities(count);
  for (std::size_t i = 0; i < count; ++i)
    priorities[order[i]] = static_cast<tbb::flow::node_priority_t>(count - i);  // oneTBB's 0 is "none"
  return priorities;
}

void Schedule::State::Run::run_graph() {
  tbb::flow::graph graph;
  graph_ = &graph;
  make_nodes(graph);
  std::exception_ptr error;
  try {
    start(graph);
    // The graph may end only when no thread of the communicator is inside one of its nodes any more.
    state_.communicator.close();
  } catch (...) {
    error = std::current_exception();
  }
  nodes_.clear();
  graph_ = nullptr;
  if (error) std::rethrow_exception(error);
}

void Schedule::State::Run::make_nodes(tbb::flow::graph& graph) {
  const std::size_t parts = state_.local.size();
  for (std::uint32_t step = 0; step < steps_.size(); ++step)
    for (std::size_t local = 0; local < parts; ++local) {
      const std::size_t predecessors = (step > 0 ? 1 : 0) + tables_[step].senders.of(local).size();
      nodes_.emplace_back(
          graph, static_cast<int>(predecessors),
          [this, step, local](const tbb::flow::continue_msg&) { execute(step, local); },
          tables_[step].priorities[local]);
    }
  nodes_left_ = nodes_.size();
}

void Schedule::State::Run::start(tbb::flow::graph& graph) {
  graph.reserve_wait();  // messages come from threads that the graph knows nothing of
  try {
    state_.communicator.open([this](Message&& message) { receive(std::move(message)); });
  } catch (...) {
    graph.release_wait();
    throw;
  }
  if (nodes_.empty()) release();
  for (std::size_t local = 0; !steps_.empty() && local < state_.local.size(); ++local) node(0, local).try_put({});
  graph.wait_for_all();
}

void Schedule::State::Run::receive(Message&& message) noexcept {
  if (!message.to.valid()) return abandon(nullptr);
  const std::size_t local = local_of(message.to);
  StepTable& table = tables_[message.step];
  const std::size_t place = table.senders.find(local, message.from);
  if (place == detail::LinkTable::kNotFound) return abandon(nullptr);
  table.arrived[table.senders.begin_of(local) + place] = std::move(message.bytes);
  node(message.step, local).try_put({});
}

void Schedule::State::Run::execute(std::uint32_t step, std::size_t local) noexcept {
  PartTask task(schedule_, state_.local[local], step);
  try {
    collect_inbox(task, local);
  } catch (...) {
    fail(step, task.part(), std::current_exception());
  }
  if (may_go_on()) carry_out_body(task);
  try {
    deliver(task, local);
  } catch (...) {
    abandon(std::current_exception());
  }
  if (!is_last(step)) node(step + 1, local).try_put({});
  if (nodes_left_.fetch_sub(1) == 1) release();
}

// An exception must not reach oneTBB, which allocates to carry it and ends the process where it cannot.
void Schedule::State::Run::carry_out_body(PartTask& task) noexcept {
  try {
    const detail::CurrentTask current(task);
    const TracedTask traced;
    const double start = state_.trace ? state_.trace->now() : 0;
    steps_[task.step_].body(task);
    if (state_.trace) record(task, start);
  } catch (...) {
    task.outbox_.clear();
    fail(task.step_, task.part_, std::current_exception());
  }
}

void Schedule::State::Run::collect_inbox(PartTask& task, std::size_t local) {
  StepTable& table = tables_[task.step_];
  const auto senders = table.senders.of(local);
  const auto arrived = std::span(table.arrived).subspan(table.senders.begin_of(local), senders.size());
  const auto empty = [](const Bytes& bytes) { return bytes.empty(); };
  task.inbox_.reserve(senders.size() - static_cast<std::size_t>(std::count_if(arrived.begin(), arrived.end(), empty)));
  for (std::size_t i = 0; i < senders.size(); ++i)
    if (!arrived[i].empty()) task.inbox_.push_back({senders[i], task.part_, task.step_, std::move(arrived[i])});
}

void Schedule::State::Run::put_in_outbox(PartTask& task, PartId to, Bytes bytes) const {
  const std::size_t local = local_of(task.part_);
  const auto& receivers = tables_[task.step_].receivers;
  const std::size_t place = receivers.find(local, to);
  TETLOOM_ASSERT(place != detail::LinkTable::kNotFound);
  if (task.outbox_.empty()) task.outbox_.resize(receivers.of(local).size());
  Message& message = task.outbox_[place];
  TETLOOM_ASSERT(!message.to.valid());
  message = {task.part_, to, task.step_ + 1, std::move(bytes)};
}

void Schedule::State::Run::deliver(PartTask& task, std::size_t local) {
  const auto receivers = tables_[task.step_].receivers.of(local);
  for (std::size_t i = 0; i < receivers.size(); ++i) {
    Message message{task.part_, receivers[i], task.step_ + 1, {}};
    if (!task.outbox_.empty()) message.bytes = std::move(task.outbox_[i].bytes);
    state_.communicator.send(std::move(message), state_.communicator.rank_of(receivers[i], state_.part_count));
  }
}

void Schedule::State::Run::record(const PartTask& task, double start) const {
  TaskRecord record{task.part_, task.step_, steps_[task.step_].name, start, state_.trace->now()};
  record.worker = tbb::this_task_arena::current_thread_index();
  record.run = trace_run_;
  const auto receivers = tables_[task.step_].receivers.of(local_of(task.part_));
  record.sent.reserve(receivers.size());
  for (std::size_t i = 0; i < receivers.size(); ++i)
    record.sent.push_back({receivers[i], task.outbox_.empty() ? 0 : task.outbox_[i].bytes.size()});
  state_.trace->add(std::move(record));
}

void Schedule::State::Run::check_cancelled() const {
  runner().check_cancelled();
  if (failed_.load(std::memory_order_relaxed) || state_.communicator.failed_elsewhere())
    throw Error(ErrorCode::Cancelled, "the run has failed in another part");
}

bool Schedule::State::Run::may_go_on() noexcept {
  if (failed_.load(std::memory_order_relaxed) || state_.communicator.failed_elsewhere()) return false;
  if (!runner().cancelled()) return true;
  host_cancelled_ = true;
  fail(0, PartId(0), nullptr);
  return false;
}

void Schedule::State::Run::fail(std::uint32_t step, PartId part, std::exception_ptr error) noexcept {
  if (error) first_error_.add(step, part, std::move(error));
  if (!failed_.exchange(true)) state_.communicator.announce_failure();
}

/// Gives up waiting for nodes that may never hear their predecessors.
void Schedule::State::Run::abandon(std::exception_ptr error) noexcept {
  if (!error) error = std::make_exception_ptr(Error(ErrorCode::Internal, "messages between parts were lost"));
  fail(0, PartId(0), std::move(error));
  release();
}

void Schedule::State::Run::release() noexcept {
  if (!released_.exchange(true)) graph_->release_wait();
}

void Schedule::State::Run::report() const {
  const std::exception_ptr& error = first_error_.get();
  const bool only_cancelled = error ? detail::is_cancellation(error) : host_cancelled_.load();
  std::int64_t sums[2] = {error && !only_cancelled, only_cancelled};
  state_.communicator.sum(sums);
  if (sums[0] != 0) fail_together(only_cancelled ? nullptr : error);
  if (error) throw Error(*failure_of([&] { std::rethrow_exception(error); }));
  if (sums[1] != 0) throw Error(ErrorCode::Cancelled, "cancelled by the host");
}

}  // namespace tetloom
