#include "bench/support/trace_file.hpp"

#include <catch2/catch.hpp>

#include "tests/support/temporary_folder.hpp"
#include "threading/runtime/replay.hpp"

using namespace tetloom;
using bench::read_trace;

TEST_CASE("a trace comes back from its file as it was written") {
  Trace trace;
  trace.add({PartId(3), 1, "send \"all\"", 1, 3, 2, TaskKind::Step, 7, {{PartId(2), 8}, {PartId(4), 0}}});
  trace.add({PartId(2), 2, "hear", 3, 4.5, 1, TaskKind::Step, 7});
  trace.add({{}, 0, "sort", 5, 6, 0, TaskKind::Serial, 8});
  trace.add({{}, 0, "loop", 6, 8, 0, TaskKind::Divisible, 9, {}, 2, 30});
  const test::TemporaryFolder folder;
  trace.write(folder / "trace.json");
  const std::vector<TaskRecord> written = trace.records(), read = read_trace(folder / "trace.json");
  REQUIRE(read.size() == written.size());
  for (std::size_t i = 0; i < read.size(); ++i) {
    CAPTURE(i);
    const TaskRecord &a = written[i], &b = read[i];
    CHECK((a.part == b.part && a.step == b.step && a.run == b.run && a.kind == b.kind));
    CHECK((a.name == b.name && a.worker == b.worker && a.threads == b.threads && a.pieces == b.pieces));
    CHECK(b.start == Approx(a.start));
    CHECK(b.end == Approx(a.end));
    REQUIRE(a.sent.size() == b.sent.size());
    for (std::size_t m = 0; m < a.sent.size(); ++m)
      CHECK((a.sent[m].to == b.sent[m].to && a.sent[m].bytes == b.sent[m].bytes));
  }
  for (const int workers : {1, 4})
    CHECK(replay_tasks(read, workers).seconds == Approx(replay_tasks(written, workers).seconds));
}

TEST_CASE("files that are no traces of tetloom are refused") {
  const test::TemporaryFolder folder;
  CHECK_THROWS_AS(read_trace(folder / "nothing.json"), std::runtime_error);
  for (const char* text :
       {"", "{}", "{\"traceEvents\":[{}]}", "{\"traceEvents\":[",
        R"({"traceEvents":[{"cat":"other","name":"x","ts":0,"dur":1,"tid":0,"args":{"run":0}}]})",
        R"({"traceEvents":[{"cat":"step","name":"x","ts":0,"dur":1,"tid":0,"args":{"run":0,"part":1}}]})"}) {
    CAPTURE(text);
    CHECK_THROWS_AS(read_trace(folder.write("other.json", text)), std::runtime_error);
  }
  CHECK(read_trace(folder.write("empty.json", "{\"traceEvents\":[]}")).empty());
}
