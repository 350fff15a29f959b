#pragma once
// What a Schedule is made of, and one run of it.
#include <oneapi/tbb/flow_graph.h>

#include <atomic>
#include <deque>
#include <exception>
#include <mutex>
#include <tuple>

#include "tetloom/tasks.hpp"
#include "threading/comm/link_table_detail.hpp"

namespace tetloom {

namespace detail {

/// Names the step that this thread is carrying out, for as long as it lives.
class CurrentTask {
 public:
  explicit CurrentTask(const PartTask& task);
  ~CurrentTask();
  CurrentTask(const CurrentTask&) = delete;
  CurrentTask& operator=(const CurrentTask&) = delete;

 private:
  const PartTask* before_;
};

bool is_cancellation(const std::exception_ptr& error);

/// Of the errors of a run the one to report: any before a cancellation, then that of the earliest step, lowest part.
class FirstError {
 public:
  void add(std::uint32_t step, PartId part, std::exception_ptr error);
  /// Pre: the run is over.
  const std::exception_ptr& get() const { return error_; }

 private:
  using Key = std::tuple<bool, std::uint32_t, PartId>;
  std::mutex mutex_;  // around the two below, in runs that fail
  Key key_;
  std::exception_ptr error_;
};

}  // namespace detail

/// A schedule with what its runs share.
struct Schedule::State {
  class Run;

  Communicator& communicator;
  const TaskRunner& runner;
  TaskRunner deaf_runner;
  std::size_t part_count;
  Trace* trace;
  std::vector<PartId> local;
  Run* run = nullptr;
};

/// A message's bytes wait in a slot of their own, by sender, until the node of the receiving step has heard all of its
/// predecessors. All nodes run, whatever fails: those after a failure only pass on empty messages, so that no rank
/// waits for ever.
class Schedule::State::Run {
 public:
  Run(Schedule& schedule, std::span<const Step> steps, bool uninterruptible);

  void carry_out();

  const TaskRunner& runner() const { return uninterruptible_ ? state_.deaf_runner : state_.runner; }
  void check_cancelled() const;
  void put_in_outbox(PartTask& task, PartId to, Bytes bytes) const;

 private:
  using Node = oneapi::tbb::flow::continue_node<oneapi::tbb::flow::continue_msg>;
  /// Links from the step, links to it and what has arrived over those.
  struct StepTable {
    detail::LinkTable receivers, senders;
    std::vector<Bytes> arrived;
    std::vector<oneapi::tbb::flow::node_priority_t> priorities;
  };

  void prepare();
  void fail_together(const std::exception_ptr& error) const;
  void make_tables();
  std::uint64_t link_imbalance() const;
  std::vector<oneapi::tbb::flow::node_priority_t> rank_by_work(const Step& step) const;

  void run_graph();
  void make_nodes(oneapi::tbb::flow::graph& graph);
  void start(oneapi::tbb::flow::graph& graph);
  void receive(Message&& message) noexcept;
  void execute(std::uint32_t step, std::size_t local) noexcept;
  void carry_out_body(PartTask& task) noexcept;
  void collect_inbox(PartTask& task, std::size_t local);
  void deliver(PartTask& task, std::size_t local);
  void record(const PartTask& task, double start) const;

  bool may_go_on() noexcept;
  void fail(std::uint32_t step, PartId part, std::exception_ptr error) noexcept;
  void abandon(std::exception_ptr error) noexcept;
  void release() noexcept;
  void report() const;

  bool is_last(std::uint32_t step) const { return step + 1 == steps_.size(); }
  std::size_t local_of(PartId part) const { return part.value - state_.local.front().value; }
  Node& node(std::uint32_t step, std::size_t local) { return nodes_[step * state_.local.size() + local]; }

  Schedule& schedule_;
  State& state_;
  std::span<const Step> steps_;
  bool uninterruptible_;
  std::uint32_t trace_run_;
  std::vector<StepTable> tables_;
  std::deque<Node> nodes_;  // by step, then by part
  oneapi::tbb::flow::graph* graph_ = nullptr;

  std::atomic<std::size_t> nodes_left_{0};   // counted down by nodes; the one that reaches 0 lets run_graph() go on
  std::atomic<bool> released_{false};        // set by that node or by abandon(), whoever is first
  std::atomic<bool> failed_{false};          // set by fail(), read by nodes; carries no data
  std::atomic<bool> host_cancelled_{false};  // set by may_go_on(), read after the run
  detail::FirstError first_error_;
};

}  // namespace tetloom
