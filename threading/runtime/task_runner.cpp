#include "tetloom/tasks.hpp"

#include <oneapi/tbb/global_control.h>
#include <oneapi/tbb/info.h>
#include <oneapi/tbb/parallel_for.h>
#include <oneapi/tbb/task_arena.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <exception>
#include <mutex>
#include <numeric>
#include <optional>
#include <vector>

namespace tetloom {

namespace tbb = oneapi::tbb;

// What runners of one call have in common.
struct TaskRunner::Ties {
  Ties(Host given, Trace* records) : host(std::move(given)), trace(records) {}

  Host host;
  Trace* trace;  // may be null
  // Raised by report() when the callback refuses to go on, read by cancelled() in all workers; carries no data.
  std::atomic<bool> refused{false};
  // Taken for the host's callback only, never around mesh data.
  std::mutex mutex;
  ProgressEvent event;
  std::chrono::steady_clock::time_point last_report;

  // Pre: mutex held.
  void report() {
    last_report = std::chrono::steady_clock::now();
    if (host.progress && !host.progress(event)) refused.store(true, std::memory_order_relaxed);
  }
};

struct TaskRunner::Threads {
  explicit Threads(int count) : arena(count) {
    // oneTBB prints a warning to stderr when it is asked for more threads than cores without being told first.
    if (count > tbb::info::default_concurrency())
      more_than_cores.emplace(tbb::global_control::max_allowed_parallelism, static_cast<std::size_t>(count));
  }

  std::optional<tbb::global_control> more_than_cores;
  tbb::task_arena arena;
};

TaskRunner::TaskRunner(int threads, Host host, Trace* trace) {
  if (threads < 0) throw Error(ErrorCode::InvalidArgument, "the number of threads must not be negative");
  const int count = threads > 0 ? threads : tbb::info::default_concurrency();
  threads_ = std::make_shared<Threads>(count);
  ties_ = std::make_shared<Ties>(std::move(host), trace);
}

TaskRunner::TaskRunner(std::shared_ptr<Threads> threads, std::shared_ptr<Ties> ties, bool hears_cancel)
    : threads_(std::move(threads)), ties_(std::move(ties)), hears_cancel_(hears_cancel) {}

TaskRunner::~TaskRunner() = default;

int TaskRunner::threads() const { return threads_->arena.max_concurrency(); }

void TaskRunner::for_each(std::size_t count, const std::function<void(std::size_t)>& body) const {
  for_blocks(count, 1, [&](std::size_t begin, std::size_t) { body(begin); });
}

void TaskRunner::for_blocks(std::size_t count, std::size_t grain,
                            const std::function<void(std::size_t, std::size_t)>& body) const {
  Trace* const trace = TracedTask::is_inside() || count == 0 ? nullptr : ties_->trace;
  if (trace != nullptr && grain == 1) return run_recorded_items(count, body, *trace);
  const std::size_t blocks = (count + grain - 1) / grain;
  const auto lanes = static_cast<int>(std::min<std::size_t>(blocks, static_cast<std::size_t>(threads())));
  const TraceSpan span(trace, "loop", lanes, blocks);
  run_blocks(count, grain, body);
}

void TaskRunner::run_recorded_items(std::size_t count, const std::function<void(std::size_t, std::size_t)>& body,
                                    Trace& trace) const {
  const std::uint32_t run = trace.begin_run();
  run_blocks(count, 1, [&](std::size_t begin, std::size_t end) {
    TaskRecord record{PartId(begin), 0, "item", trace.now()};
    body(begin, end);
    record.end = trace.now();
    record.worker = tbb::this_task_arena::current_thread_index();
    record.run = run;
    trace.add(std::move(record));
  });
}

void TaskRunner::run_blocks(std::size_t count, std::size_t grain,
                            const std::function<void(std::size_t, std::size_t)>& body) const {
  if (count == 0) return;
  check_cancelled();
  const std::size_t blocks = (count + grain - 1) / grain;
  // Blocks are handed out in order, one at a time: the sequence of estimated work that callers set up is kept.
  std::atomic<std::size_t> next{0};  // counts blocks taken by the lanes below; each block goes to the one that took it
  const auto lanes = std::min<std::size_t>(blocks, static_cast<std::size_t>(threads()));
  // What a body throws is carried here and not by oneTBB, which allocates to do so and ends the process where it
  // cannot.
  std::vector<std::exception_ptr> thrown(lanes);
  const auto run_lane = [&](std::size_t lane) {
    for (std::size_t block; (block = next.fetch_add(1, std::memory_order_relaxed)) < blocks;) {
      if (cancelled()) return;
      const TracedTask task;
      try {
        body(block * grain, std::min(count, (block + 1) * grain));
      } catch (...) {
        thrown[lane] = std::current_exception();
        next.store(blocks, std::memory_order_relaxed);
      }
    }
  };
  // A thread that waits for the end of a loop helps with this loop alone. It might otherwise begin something long, such
  // as the step of another part, and begin a next one while it waits in there, until its stack is full.
  const auto loop = [&] {
    if (lanes == 1) return run_lane(0);
    tbb::parallel_for(std::size_t{0}, lanes, run_lane, tbb::simple_partitioner{});
  };
  threads_->arena.execute([&] { tbb::this_task_arena::isolate(loop); });
  for (const std::exception_ptr& error : thrown)
    if (error) std::rethrow_exception(error);
  check_cancelled();
}

void TaskRunner::for_each_largest_first(std::span<const double> work,
                                        const std::function<void(std::size_t)>& body) const {
  std::vector<std::size_t> order(work.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return work[a] > work[b]; });
  for_each(order.size(), [&](std::size_t i) { body(order[i]); });
}

void TaskRunner::execute(const std::function<void()>& call) const {
  std::exception_ptr thrown;
  threads_->arena.execute([&] {
    try {
      call();
    } catch (...) {
      thrown = std::current_exception();
    }
  });
  if (thrown) std::rethrow_exception(thrown);
}

TaskRunner TaskRunner::uninterruptible() const { return TaskRunner(threads_, ties_, false); }

TaskRunner TaskRunner::with_idle_threads(int factor) const {
  const int cores = std::max(threads(), tbb::info::default_concurrency());
  const int count = factor < cores / threads() ? factor * threads() : cores;
  return TaskRunner(count > threads() ? std::make_shared<Threads>(count) : threads_, ties_, hears_cancel_);
}

void TaskRunner::begin_stage(Stage stage, std::uint64_t total) const {
  const std::lock_guard lock(ties_->mutex);
  ties_->event = {stage, {}, 0, total};
  ties_->report();
}

void TaskRunner::advance(std::uint64_t amount, ModelEntity entity) const {
  const std::lock_guard lock(ties_->mutex);
  ties_->event.done += amount;
  ties_->event.entity = entity;
  const auto since = std::chrono::steady_clock::now() - ties_->last_report;
  if (since >= std::chrono::milliseconds(20) || ties_->event.done == ties_->event.total) ties_->report();
}

bool TaskRunner::cancelled() const {
  if (!hears_cancel_) return false;
  if (ties_->refused.load(std::memory_order_relaxed)) return true;
  const Host& host = ties_->host;
  return (host.cancel && host.cancel->cancelled()) || (host.wants_stop && host.wants_stop());
}

void TaskRunner::check_cancelled() const {
  if (cancelled()) throw Error(ErrorCode::Cancelled, "cancelled by the host");
}

}  // namespace tetloom
