#include "tetloom/tasks.hpp"

#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <chrono>
#include <nlohmann/json.hpp>
#include <set>

#include "tests/support/temporary_folder.hpp"
#include "threading/runtime/replay.hpp"

using namespace tetloom;

namespace {

nlohmann::json written(const Trace& trace, int rank) {
  const test::TemporaryFolder folder;
  trace.write(folder / "trace.json", rank);
  return nlohmann::json::parse(test::file_content(folder / "trace.json"));
}

}  // namespace

TEST_CASE("the trace of a run names every task, and its file parses") {
  const auto communicator = make_thread_communicator();
  const TaskRunner runner(2);
  Trace trace;
  const std::vector<PartId> both{PartId(0), PartId(1)};
  const Links links = neighbour_links([&](PartId) { return std::span<const PartId>(both); });
  const std::string odd = "a \"step\" \\ with\na line";
  const std::vector<Step> steps{{"send", [](PartTask& task) { task.send(PartId(1), Bytes(7)); }, links, {}},
                                {odd, [](PartTask&) {}, {}, {}}};
  Schedule(*communicator, runner, 2, &trace).run(steps);
  CHECK(trace.records().size() == 4);

  std::multiset<std::string> tasks;
  const auto json = written(trace, 3);
  for (const auto& event : json.at("traceEvents")) {
    CHECK(event.at("ph") == "X");
    CHECK(event.at("pid") == 3);
    CHECK(event.at("dur") >= 0.0);
    CHECK(event.at("ts") >= 0.0);
    CHECK(event.at("args").at("bytes_sent") == (event.at("name") == "send" ? 7 : 0));
    tasks.insert(event.at("name").get<std::string>() + "/" + event.at("args").at("part").dump());
  }
  CHECK(tasks == std::multiset<std::string>{"send/0", "send/1", odd + "/0", odd + "/1"});
}

TEST_CASE("records are sorted by start, and a trace that cannot be written is an error") {
  Trace trace;
  for (const double start : {3.0, 1.0, 2.0}) trace.add({PartId(0), 0, "x", start, start + 1});
  const auto records = trace.records();
  REQUIRE(records.size() == 3);
  CHECK(records[0].start == 1.0);
  CHECK(records[2].start == 3.0);
  CHECK(written(Trace(), 0).at("traceEvents").empty());
  CHECK_THROWS_AS(trace.write("/no/such/folder/trace.json"), Error);
}

TEST_CASE("a step names its messages, and each run has a number") {
  const auto communicator = make_thread_communicator();
  const TaskRunner runner(2);
  Trace trace;
  const std::vector<PartId> from_first{PartId(1), PartId(2)}, nobody;
  const std::vector<std::vector<PartId>> to_first{{}, {PartId(0)}, {PartId(0)}};
  const Links links{[&](PartId part) { return std::span(part == PartId(0) ? from_first : nobody); },
                    [&](PartId part) { return std::span(to_first[part.value]); }};
  const auto send = [](PartTask& task) {
    if (task.part() == PartId(0)) task.send(PartId(2), Bytes(5));
  };
  const std::vector<Step> steps{{"send", send, links, {}}, {"hear", [](PartTask&) {}, links, {}}};
  Schedule schedule(*communicator, runner, 3, &trace);
  for (int run = 0; run < 2; ++run) schedule.run(steps);

  REQUIRE(trace.records().size() == 12);
  std::array<int, 2> of_run{};
  for (const TaskRecord& record : trace.records()) {
    CAPTURE(record.step, record.part.value);
    CHECK(record.kind == TaskKind::Step);
    REQUIRE(record.run < 2);
    ++of_run[record.run];
    const bool sends = record.step == 0 && record.part == PartId(0);  // nobody hears of the last step
    REQUIRE(record.sent.size() == (sends ? 2 : 0));
    CHECK(record.bytes_sent() == (sends ? 5 : 0));
    if (!sends) continue;
    CHECK((record.sent[0].to == PartId(1) && record.sent[0].bytes == 0));
    CHECK((record.sent[1].to == PartId(2) && record.sent[1].bytes == 5));
  }
  CHECK(of_run == std::array{6, 6});
}

TEST_CASE("work outside of schedules is recorded with its own number, and not without a trace") {
  Trace trace;
  { const TraceSpan span(&trace, "sort"); }
  { const TraceSpan span(&trace, "loop", 4, 30); }
  { const TraceSpan span(nullptr, "nowhere"); }
  const auto records = trace.records();
  REQUIRE(records.size() == 2);
  CHECK((records[0].kind == TaskKind::Serial && records[0].threads == 1 && records[0].run == 0));
  CHECK((records[1].kind == TaskKind::Divisible && records[1].threads == 4 && records[1].pieces == 30));
  CHECK((records[1].run == 1 && records[1].start >= records[0].end && records[1].seconds() >= 0));
}

TEST_CASE("a runner records its loops, those inside of tasks with these alone") {
  Trace trace;
  const TaskRunner runner(2, {}, &trace);
  runner.for_each(3, [&](std::size_t) { runner.for_blocks(100, 10, [](std::size_t, std::size_t) {}); });
  runner.uninterruptible().for_blocks(100, 30, [](std::size_t, std::size_t) {});
  runner.for_blocks(5, 30, [](std::size_t, std::size_t) {});
  runner.for_blocks(0, 30, [](std::size_t, std::size_t) {});
  const auto communicator = make_thread_communicator();
  const auto step = [&](PartTask&) { runner.for_each(2, [](std::size_t) {}); };
  Schedule(*communicator, runner, 2).run(std::vector<Step>{{"step", step, {}, {}}});
  TaskRunner(2).for_each(3, [](std::size_t) {});
  const auto records = trace.records();
  REQUIRE(records.size() == 5);
  std::set<std::size_t> items;
  for (std::size_t i = 0; i < 3; ++i) {
    CHECK((records[i].kind == TaskKind::Step && records[i].run == 0 && records[i].step == 0));
    CHECK((records[i].sent.empty() && records[i].seconds() >= 0));
    items.insert(records[i].part.value);
  }
  CHECK(items == std::set<std::size_t>{0, 1, 2});
  CHECK((records[3].kind == TaskKind::Divisible && records[3].threads == 2 && records[3].pieces == 4));
  CHECK((records[4].kind == TaskKind::Divisible && records[4].threads == 1 && records[4].pieces == 1));
}

TEST_CASE("items of a loop are replayed side by side, the longest first") {
  Trace trace;
  const TaskRunner runner(1, {}, &trace);
  runner.for_each(4, [](std::size_t) {
    const auto end = std::chrono::steady_clock::now() + std::chrono::milliseconds(1);
    while (std::chrono::steady_clock::now() < end) {}
  });
  const auto records = trace.records();
  double longest = 0;
  for (const TaskRecord& record : records) longest = std::max(longest, record.seconds());
  const Replay one = replay_tasks(records, 1), many = replay_tasks(records, 4);
  CHECK(one.seconds == Approx(one.work));
  CHECK(many.seconds == Approx(longest));
}

TEST_CASE("the file of a trace holds what a replay needs") {
  Trace trace;
  trace.add({PartId(3), 1, "send", 1, 3, 0, TaskKind::Step, 7, {{PartId(2), 8}, {PartId(4), 0}}});
  trace.add({{}, 0, "loop", 4, 5, 0, TaskKind::Divisible, 8, {}, 2, 30});
  const auto events = written(trace, 0).at("traceEvents");
  REQUIRE(events.size() == 2);
  CHECK(events[0].at("cat") == "step");
  CHECK(events[0].at("args") ==
        nlohmann::json::parse(R"({"run":7,"part":3,"step":1,"bytes_sent":8,"sent":[[2,8],[4,0]]})"));
  CHECK(events[1].at("cat") == "divisible");
  CHECK(events[1].at("args") == nlohmann::json::parse(R"({"run":8,"threads":2,"pieces":30})"));
}
