#include "threading/runtime/replay.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <map>
#include <random>

#include "tests/support/error_of.hpp"
#include "tetloom/tasks.hpp"

using namespace tetloom;
using test::error_of;

namespace {

constexpr MessageCosts kFree{0, HUGE_VAL};

/// A step of `part` that takes `seconds`; when it started does not matter.
TaskRecord step_of(std::uint32_t part, std::uint32_t step, double seconds, std::vector<SentMessage> sent = {}) {
  return {PartId(part), step, "step", 0, seconds, 0, TaskKind::Step, 0, std::move(sent)};
}

TaskRecord in_run(TaskRecord record, std::uint32_t run) {
  record.run = run;
  return record;
}

TaskRecord span_of(TaskKind kind, std::uint32_t run, double seconds, int threads = 1, std::uint64_t pieces = 0) {
  return {{}, 0, "span", 0, seconds, 0, kind, run, {}, threads, pieces};
}

double seconds_of(const std::vector<TaskRecord>& records, int workers, const MessageCosts& costs = kFree) {
  return replay_tasks(records, workers, costs).seconds;
}

/// The longest chain, by recursion over the senders of each step.
double longest_chain(const std::vector<TaskRecord>& records) {
  std::map<std::pair<std::uint32_t, std::uint32_t>, double> ends;  // by step and part
  double longest = 0;
  for (const TaskRecord& record : records) {  // sorted by step
    const double end = ends[{record.step, record.part.value}] + record.seconds();
    longest = std::max(longest, end);
    const auto reach = [&](PartId to) {
      double& start = ends[{record.step + 1, to.value}];
      start = std::max(start, end);
    };
    reach(record.part);
    for (const SentMessage& message : record.sent) reach(message.to);
  }
  return longest;
}

}  // namespace

TEST_CASE("independent tasks are shared by the workers, the longest first") {
  const std::vector<TaskRecord> equal{step_of(0, 0, 1), step_of(1, 0, 1), step_of(2, 0, 1), step_of(3, 0, 1)};
  CHECK(seconds_of(equal, 1) == Approx(4));
  CHECK(seconds_of(equal, 2) == Approx(2));
  CHECK(seconds_of(equal, 3) == Approx(2));
  CHECK(seconds_of(equal, 4) == Approx(1));
  CHECK(seconds_of(equal, 64) == Approx(1));
  CHECK(replay_tasks(equal, 3).work == Approx(4));
  // In the order of their parts these would take 1 + 4.
  const std::vector<TaskRecord> uneven{step_of(0, 0, 1), step_of(1, 0, 1), step_of(2, 0, 1), step_of(3, 0, 1),
                                       step_of(4, 0, 4)};
  CHECK(seconds_of(uneven, 2) == Approx(4));
}

TEST_CASE("the steps of a part follow each other on any number of workers") {
  const std::vector<TaskRecord> chain{step_of(0, 1, 2), step_of(0, 0, 1), step_of(0, 2, 3)};
  for (const int workers : {1, 2, 64}) CHECK(seconds_of(chain, workers) == Approx(6));
  CHECK(seconds_of(chain, 2, {10, 1}) == Approx(6));  // a part sends no message to itself
}

TEST_CASE("a step waits for those that its part hears from, and for no other") {
  // Part 0 hands out work, parts 1 to 4 do it, part 0 collects it; part 5 has nothing to do with them.
  std::vector<TaskRecord> records{step_of(0, 0, 1, {{PartId(1)}, {PartId(2)}, {PartId(3)}, {PartId(4)}}),
                                  step_of(0, 1, 0), step_of(0, 2, 1)};
  for (std::uint32_t part = 1; part <= 4; ++part) {
    records.push_back(step_of(part, 0, 0));
    records.push_back(step_of(part, 1, 2, {{PartId(0)}}));
  }
  CHECK(seconds_of(records, 1) == Approx(10));
  CHECK(seconds_of(records, 2) == Approx(6));
  CHECK(seconds_of(records, 3) == Approx(6));
  CHECK(seconds_of(records, 4) == Approx(4));
  CHECK(seconds_of(records, 100) == Approx(4));
  records.push_back(step_of(5, 0, 5));
  CHECK(seconds_of(records, 5) == Approx(5));
  CHECK(seconds_of(records, 1) == Approx(15));
}

TEST_CASE("messages between parts cost latency and bytes") {
  const std::vector<TaskRecord> records{step_of(0, 0, 1, {{PartId(1), 20}}), step_of(1, 0, 3), step_of(0, 1, 1),
                                        step_of(1, 1, 1)};
  CHECK(seconds_of(records, 2) == Approx(4));
  CHECK(seconds_of(records, 2, {0.5, 10}) == Approx(1 + 0.5 + 20.0 / 10 + 1));
  CHECK(seconds_of(records, 2, {0.5, 1000}) == Approx(4));  // it is there before the receiver is free
  CHECK(seconds_of(records, 1, {100, 1e9}) == Approx(3 + 1 + 100 + 1).epsilon(1e-6));  // part 1, part 0, the message
}

TEST_CASE("runs follow each other, and work between them is serial or divided") {
  std::vector<TaskRecord> records{in_run(step_of(0, 0, 1), 4), in_run(step_of(1, 0, 3), 4), in_run(step_of(0, 0, 3), 9),
                                  in_run(step_of(1, 0, 1), 9)};
  CHECK(seconds_of(records, 2) == Approx(6));
  records.push_back(span_of(TaskKind::Serial, 5, 2));
  CHECK(seconds_of(records, 2) == Approx(8));
  records.push_back(span_of(TaskKind::Divisible, 6, 6, 2));
  CHECK(seconds_of(records, 1) == Approx(8 + 2 + 12));
  CHECK(seconds_of(records, 2) == Approx(8 + 6));
  CHECK(seconds_of(records, 64) == Approx(8 + 12.0 / 64));
  records.back().pieces = 3;
  CHECK(seconds_of(records, 64) == Approx(8 + 4));
  CHECK(seconds_of(records, 2) == Approx(8 + 8));  // one of the two has two pieces
  CHECK(replay_tasks(records, 64).work == Approx(8 + 2 + 12));
}

TEST_CASE("no tasks take no time, and what has no record is not waited for") {
  CHECK(seconds_of({}, 4) == 0);
  CHECK(recorded_seconds({}) == 0);
  CHECK(seconds_of({step_of(0, 5, 2)}, 4) == Approx(2));
  CHECK(seconds_of({step_of(0, 0, 2, {{PartId(7), 1}})}, 4) == Approx(2));
}

TEST_CASE("replays of random runs lie between the bounds of greedy schedules") {
  for (unsigned seed = 0; seed < 50; ++seed) {
    CAPTURE(seed);
    std::mt19937 generator(seed);
    const auto random = [&] { return static_cast<std::uint32_t>(generator()); };
    const std::uint32_t parts = 1 + random() % 20, steps = 1 + random() % 6;
    std::vector<TaskRecord> records;
    for (std::uint32_t step = 0; step < steps; ++step)
      for (std::uint32_t part = 0; part < parts; ++part) {
        records.push_back(step_of(part, step, 0.1 * static_cast<double>(random() % 100)));
        for (std::uint32_t to = 0; to < parts; ++to)
          if (random() % 4 == 0) records.back().sent.push_back({PartId(to), random() % 1000});
      }
    const double chain = longest_chain(records);
    std::vector<TaskRecord> shuffled = records;
    std::shuffle(shuffled.begin(), shuffled.end(), generator);
    for (const int workers : {1, 2, 3, 8, 1000}) {
      CAPTURE(workers);
      const Replay replay = replay_tasks(records, workers, kFree);
      CHECK(replay.seconds >= std::max(replay.work / workers, chain) * (1 - 1e-12));
      CHECK(replay.seconds <= (replay.work / workers + chain) * (1 + 1e-12));
      CHECK(replay_tasks(shuffled, workers, kFree).seconds == replay.seconds);
    }
    CHECK(seconds_of(records, 1) == Approx(replay_tasks(records, 1).work));
    CHECK(seconds_of(records, 1000) == Approx(chain));
  }
}

TEST_CASE("a trace of a schedule is replayed with its own links") {
  // A relay: part k's work of step k waits for part k - 1, so that nothing can be done at once but the empty steps.
  constexpr std::size_t kCount = 4;
  std::vector<std::vector<PartId>> next(kCount), previous(kCount);
  for (std::size_t part = 0; part + 1 < kCount; ++part) {
    next[part] = {PartId(part + 1)};
    previous[part + 1] = {PartId(part)};
  }
  const Links links{[&](PartId part) { return std::span<const PartId>(next[part.value]); },
                    [&](PartId part) { return std::span<const PartId>(previous[part.value]); }};
  std::vector<Step> steps;
  for (std::uint32_t step = 0; step < kCount; ++step) steps.push_back({"relay", [](PartTask&) {}, links, {}});
  const auto communicator = make_thread_communicator();
  Trace trace;
  Schedule(*communicator, TaskRunner(1), kCount, &trace).run(steps);
  std::vector<TaskRecord> records = trace.records();
  for (TaskRecord& record : records) record.end = record.start + (record.step == record.part.value ? 1 : 0);
  CHECK(seconds_of(records, 8) == Approx(4));
  for (TaskRecord& record : records) record.sent.clear();
  CHECK(seconds_of(records, 8) == Approx(1));
}

TEST_CASE("the recorded seconds count what overlaps once") {
  std::vector<TaskRecord> records{step_of(0, 0, 2), step_of(1, 0, 3), step_of(2, 0, 1)};
  CHECK(recorded_seconds(records) == Approx(3));
  records[1].start = 1, records[2].start = 5, records[2].end = 7;
  CHECK(recorded_seconds(records) == Approx(5));
}

TEST_CASE("a replay refuses what cannot have been") {
  const std::vector<TaskRecord> good{step_of(0, 0, 1)};
  const auto code = [](const std::vector<TaskRecord>& records, int workers, const MessageCosts& costs) {
    return error_of([&] { replay_tasks(records, workers, costs); }).code;
  };
  CHECK(code(good, 0, {}) == ErrorCode::InvalidArgument);
  CHECK(code(good, 1, {-1, 1}) == ErrorCode::InvalidArgument);
  CHECK(code(good, 1, {0, 0}) == ErrorCode::InvalidArgument);
  CHECK(code({step_of(0, 0, 1), step_of(0, 0, 1)}, 1, {}) == ErrorCode::InvalidArgument);
  CHECK(code({step_of(0, 0, -1)}, 1, {}) == ErrorCode::InvalidArgument);
  CHECK(code({span_of(TaskKind::Divisible, 0, 1, 0)}, 1, {}) == ErrorCode::InvalidArgument);
  CHECK(code({span_of(TaskKind::Serial, 0, 1), step_of(0, 0, 1)}, 1, {}) == ErrorCode::InvalidArgument);
}
