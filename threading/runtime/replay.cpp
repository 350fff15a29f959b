#include "threading/runtime/replay.hpp"

#include <algorithm>
#include <cmath>
#include <queue>
#include <tuple>
#include <utility>
#include <vector>

namespace tetloom {
namespace {

[[noreturn]] void refuse(const char* why) { throw Error(ErrorCode::InvalidArgument, why); }

using Place = std::tuple<std::uint32_t, std::uint32_t, PartId>;  // run, step, part

Place place_of(const TaskRecord& record) { return {record.run, record.step, record.part}; }

/// The steps of one run, and who waits for whom.
class Graph {
 public:
  /// `records`: sorted by place.
  Graph(std::span<const TaskRecord* const> records, const MessageCosts& costs) : records_(records) {
    begins_.push_back(0);
    for (const TaskRecord* record : records_) {
      add_edge(record->step + 1, record->part, 0);
      for (const SentMessage& message : record->sent)
        if (message.to != record->part) add_edge(record->step + 1, message.to, costs.seconds(message.bytes));
      begins_.push_back(edges_.size());
    }
  }

  struct Edge {
    std::size_t to;
    double delay;
  };

  std::size_t size() const { return records_.size(); }
  double seconds(std::size_t task) const { return records_[task]->seconds(); }
  std::span<const Edge> edges(std::size_t task) const {
    return std::span(edges_).subspan(begins_[task], begins_[task + 1] - begins_[task]);
  }

 private:
  void add_edge(std::uint32_t step, PartId part, double delay) {
    const Place wanted{records_.front()->run, step, part};
    const auto found = std::lower_bound(records_.begin(), records_.end(), wanted,
                                        [](const TaskRecord* a, const Place& b) { return place_of(*a) < b; });
    if (found == records_.end() || place_of(**found) != wanted) return;
    edges_.push_back({static_cast<std::size_t>(found - records_.begin()), delay});
  }

  std::span<const TaskRecord* const> records_;
  std::vector<std::size_t> begins_;
  std::vector<Edge> edges_;
};

/// One run on a number of workers, event by event.
class Simulation {
 public:
  Simulation(const Graph& graph, int workers)
      : graph_(graph),
        idle_(workers),
        waits_for_(graph.size(), 0),
        ready_at_(graph.size(), 0),
        startable_(Longer{&graph}) {
    for (std::size_t task = 0; task < graph_.size(); ++task)
      for (const Graph::Edge& edge : graph_.edges(task)) ++waits_for_[edge.to];
  }

  double run() {
    for (std::size_t task = 0; task < graph_.size(); ++task)
      if (waits_for_[task] == 0) arriving_.push({0, task});
    while (!arriving_.empty() || !startable_.empty() || !running_.empty()) {
      start_tasks();
      now_ = next_event();
      while (!running_.empty() && running_.top().first <= now_) end_task();
      while (!arriving_.empty() && arriving_.top().first <= now_) {
        startable_.push(arriving_.top().second);
        arriving_.pop();
      }
    }
    return now_;
  }

 private:
  using Event = std::pair<double, std::size_t>;
  using Events = std::priority_queue<Event, std::vector<Event>, std::greater<>>;
  struct Longer {
    const Graph* graph;
    /// Whether `b` starts before `a`.
    bool operator()(std::size_t a, std::size_t b) const {
      return std::pair(graph->seconds(a), b) < std::pair(graph->seconds(b), a);
    }
  };

  void start_tasks() {
    for (; idle_ > 0 && !startable_.empty(); --idle_) {
      running_.push({now_ + graph_.seconds(startable_.top()), startable_.top()});
      startable_.pop();
    }
  }

  double next_event() const {
    if (running_.empty() && arriving_.empty()) return now_;
    if (running_.empty()) return arriving_.top().first;
    if (arriving_.empty()) return running_.top().first;
    return std::min(running_.top().first, arriving_.top().first);
  }

  void end_task() {
    const auto [end, task] = running_.top();
    running_.pop();
    ++idle_;
    for (const Graph::Edge& edge : graph_.edges(task)) {
      ready_at_[edge.to] = std::max(ready_at_[edge.to], end + edge.delay);
      if (--waits_for_[edge.to] == 0) arriving_.push({ready_at_[edge.to], edge.to});
    }
  }

  const Graph& graph_;
  int idle_;
  std::vector<std::size_t> waits_for_;
  std::vector<double> ready_at_;
  Events arriving_, running_;  // by when all messages are there, by when they end
  std::priority_queue<std::size_t, std::vector<std::size_t>, Longer> startable_;
  double now_ = 0;
};

double divided_seconds(const TaskRecord& record, int workers) {
  if (record.kind == TaskKind::Serial) return record.seconds();
  double sharers = workers;
  if (record.pieces > 0) {
    const auto pieces = static_cast<double>(record.pieces);
    sharers = pieces / std::ceil(pieces / workers);  // pieces are alike: some workers have one more than others
  }
  return record.seconds() * record.threads / sharers;
}

void check(const TaskRecord& record) {
  if (!(record.seconds() >= 0) || !std::isfinite(record.seconds())) refuse("replay: a record ends before it starts");
  if (record.threads < 1) refuse("replay: a record of no threads");
}

/// By run, and the steps of a run by step and part.
std::vector<const TaskRecord*> sort_by_place(std::span<const TaskRecord> records) {
  std::vector<const TaskRecord*> sorted;
  sorted.reserve(records.size());
  for (const TaskRecord& record : records) {
    check(record);
    sorted.push_back(&record);
  }
  std::sort(sorted.begin(), sorted.end(),
            [](const TaskRecord* a, const TaskRecord* b) { return place_of(*a) < place_of(*b); });
  const auto same = [](const TaskRecord* a, const TaskRecord* b) { return place_of(*a) == place_of(*b); };
  if (std::adjacent_find(sorted.begin(), sorted.end(), same) != sorted.end())
    refuse("replay: two records of the same step of a part");
  return sorted;
}

}  // namespace

Replay replay_tasks(std::span<const TaskRecord> records, int workers, const MessageCosts& costs) {
  if (workers < 1) refuse("replay: there must be a worker");
  if (!(costs.latency >= 0) || !(costs.bandwidth > 0)) refuse("replay: costs of messages must be times");
  const std::vector<const TaskRecord*> sorted = sort_by_place(records);
  Replay replay;
  for (auto begin = sorted.begin(); begin != sorted.end();) {
    const auto end = std::find_if(begin, sorted.end(), [&](const TaskRecord* r) { return r->run != (*begin)->run; });
    const auto steps = std::find_if(begin, end, [](const TaskRecord* r) { return r->kind != TaskKind::Step; });
    if (steps == end) {
      replay.seconds += Simulation(Graph({begin, end}, costs), workers).run();
    } else {
      replay.seconds += divided_seconds(**begin, workers);
      if (end - begin > 1) refuse("replay: work outside of schedules shares its number with other records");
    }
    for (; begin != end; ++begin) replay.work += (*begin)->seconds() * (*begin)->threads;
  }
  return replay;
}

double recorded_seconds(std::span<const TaskRecord> records) {
  std::vector<std::pair<double, double>> intervals;
  for (const TaskRecord& record : records) intervals.emplace_back(record.start, record.end);
  std::sort(intervals.begin(), intervals.end());
  double sum = 0, covered = -HUGE_VAL;
  for (const auto& [start, end] : intervals) {
    if (end <= covered) continue;
    sum += end - std::max(start, covered);
    covered = end;
  }
  return sum;
}

}  // namespace tetloom
