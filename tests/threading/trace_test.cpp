#include "threading/trace.hpp"

#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>
#include <set>

#include "tests/support/temporary_folder.hpp"
#include "threading/schedule.hpp"

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
  for (const double start : {3.0, 1.0, 2.0}) trace.add({PartId(0), 0, "x", start, start + 1, 0, 0});
  const auto records = trace.records();
  REQUIRE(records.size() == 3);
  CHECK(records[0].start == 1.0);
  CHECK(records[2].start == 3.0);
  CHECK(written(Trace(), 0).at("traceEvents").empty());
  CHECK_THROWS_AS(trace.write("/no/such/folder/trace.json"), Error);
}
