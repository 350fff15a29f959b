#include "tetloom/tasks.hpp"

#include <algorithm>
#include <atomic>
#include <catch2/catch.hpp>
#include <numeric>
#include <thread>
#include <vector>

#include "tests/support/error_of.hpp"
#include "tests/support/mixed_mesh.hpp"
#include "tests/support/temporary_folder.hpp"
#include "tetloom/check.hpp"
#include "tetloom/io.hpp"

using namespace tetloom;

TEST_CASE("every item is visited once, on any number of threads") {
  for (const int threads : {1, 2, 5}) {
    const TaskRunner runner(threads);
    CHECK(runner.threads() == threads);
    std::vector<int> visits(1000, 0);
    runner.for_each(visits.size(), [&](std::size_t i) { ++visits[i]; });
    std::atomic<int> misplaced{0};  // Catch2's assertions may not run in two threads at once
    runner.for_blocks(visits.size(), 7, [&](std::size_t begin, std::size_t end) {
      if (begin % 7 != 0) ++misplaced;
      for (std::size_t i = begin; i < end; ++i) ++visits[i];
    });
    CHECK(misplaced == 0);
    CHECK(visits == std::vector<int>(1000, 2));
  }
}

TEST_CASE("idle threads are borrowed up to the cores of the process, with the same host") {
  int events = 0;
  const auto count_event = [&](const ProgressEvent&) {
    ++events;
    return true;
  };
  const int cores = TaskRunner(0).threads();
  for (const int threads : {1, cores, cores + 3}) {
    CancelToken token;
    const TaskRunner runner(threads, {count_event, &token});
    CHECK(runner.with_idle_threads(1).threads() == threads);
    CHECK(runner.with_idle_threads(1 << 30).threads() == std::max(threads, cores));
    const TaskRunner wide = runner.with_idle_threads(2);
    CHECK(wide.threads() == std::max(threads, std::min(2 * threads, cores)));
    std::atomic<int> visits{0};
    wide.for_each(1000, [&](std::size_t) { ++visits; });
    CHECK(visits == 1000);
    events = 0;
    wide.begin_stage(Stage::Volume, 1);
    CHECK(events == 1);
    token.cancel();
    CHECK(wide.cancelled());
    CHECK_FALSE(wide.uninterruptible().with_idle_threads(2).cancelled());
  }
}

TEST_CASE("the largest item starts first") {
  const TaskRunner runner(1);
  std::vector<std::size_t> order;
  runner.for_each_largest_first(std::vector<double>{1, 5, 3, 5}, [&](std::size_t i) { order.push_back(i); });
  CHECK(order == std::vector<std::size_t>{1, 3, 2, 0});
}

TEST_CASE("loops can be nested") {
  const TaskRunner runner(3);
  std::vector<std::size_t> sums(20, 0);
  runner.for_each(sums.size(), [&](std::size_t i) {
    std::vector<std::size_t> parts(10, 0);
    runner.for_each(parts.size(), [&](std::size_t j) { parts[j] = i; });
    sums[i] = std::accumulate(parts.begin(), parts.end(), std::size_t{0});
  });
  for (std::size_t i = 0; i < sums.size(); ++i) CHECK(sums[i] == 10 * i);
}

TEST_CASE("an exception of a body reaches the caller and ends the loop") {
  const TaskRunner runner(2);
  const auto loop = [&] {
    runner.for_each(100, [](std::size_t i) {
      if (i == 13) throw Error(ErrorCode::FaceFailed, "thirteen");
    });
  };
  CHECK_THROWS_WITH(loop(), "thirteen");
  int visits = 0;
  TaskRunner(1).for_each(3, [&](std::size_t) { ++visits; });
  CHECK(visits == 3);
}

TEST_CASE("a raised token cancels loops that are running and loops that start later") {
  CancelToken token;
  const TaskRunner runner(2, {{}, &token});
  const auto code_of = [&](const auto& call) {
    try {
      call();
    } catch (const Error& error) {
      return error.code();
    }
    return ErrorCode::Internal;
  };
  std::atomic<int> visits{0};
  CHECK(code_of([&] {
          runner.for_each(100000, [&](std::size_t i) {
            ++visits;
            if (i == 10) token.cancel();
          });
        }) == ErrorCode::Cancelled);
  CHECK(visits < 100000);
  CHECK(code_of([&] { runner.for_each(1, [](std::size_t) {}); }) == ErrorCode::Cancelled);
}

TEST_CASE("the host hears of the start and the end of a stage and can refuse to go on") {
  std::vector<ProgressEvent> events;
  Host host;
  host.progress = [&](const ProgressEvent& event) {
    events.push_back(event);
    return event.stage != Stage::Volume;
  };
  const TaskRunner runner(2, host);
  runner.begin_stage(Stage::Faces, 5);
  for (int i = 0; i < 5; ++i) runner.advance();
  REQUIRE(events.size() >= 2);
  CHECK(events.front().done == 0);
  CHECK(events.back().done == 5);
  CHECK(events.back().total == 5);
  CHECK_FALSE(runner.cancelled());
  runner.begin_stage(Stage::Volume, 1);
  CHECK(runner.cancelled());
}

TEST_CASE("a host that is asked whether to stop ends the run when it says so, for good") {
  std::atomic<int> asked{0};
  Host host;
  host.wants_stop = [&] { return ++asked > 10; };
  const TaskRunner runner(1, host);
  int visits = 0;
  try {
    runner.for_each(100, [&](std::size_t) { ++visits; });
    FAIL("it was not cancelled");
  } catch (const Error& error) {
    CHECK(error.code() == ErrorCode::Cancelled);
  }
  CHECK(visits > 0);
  CHECK(visits <= 10);
  CHECK(runner.cancelled());
  CHECK_FALSE(runner.uninterruptible().cancelled());
}

TEST_CASE("a negative number of threads is refused") { CHECK_THROWS_AS(TaskRunner(-1), Error); }

TEST_CASE("a runner carries out the loops of core, with the same results on any number of threads") {
  const Mesh mesh = test::make_mixed_box(24, 24, 24, 5, true);
  const QualityReport expected = compute_quality(mesh);
  const test::TemporaryFolder folder;
  write_mesh(mesh, folder / "serial.msh");
  for (const int threads : {1, 2, 6}) {
    const TaskRunner runner(threads);
    const QualityReport quality = compute_quality(mesh, nullptr, runner);
    CHECK(quality.tets.mean_ratio_mean == expected.tets.mean_ratio_mean);
    CHECK(quality.tets.mean_ratio_p1 == expected.tets.mean_ratio_p1);
    CHECK(quality.cells.volume == expected.cells.volume);
    CHECK(quality.tets.edges.mean_length == expected.tets.edges.mean_length);
    CHECK(mesh_digest(mesh, runner) == mesh_digest(mesh));
    CHECK(validate_mesh(mesh, runner).valid());
    write_mesh(mesh, folder / "parallel.msh", nullptr, runner);
    CHECK(test::file_content(folder / "parallel.msh") == test::file_content(folder / "serial.msh"));
  }
}

TEST_CASE("a cancelled run ends the loops of core, and a file that is being written is gone") {
  const Mesh mesh = test::make_mixed_box(24, 24, 24, 5, true);
  const test::TemporaryFolder folder;
  std::atomic<int> questions{0};  // asked by all threads; the answer is yes from some time on
  const TaskRunner runner(3, {.progress = {}, .cancel = nullptr, .wants_stop = [&] { return ++questions > 40; }});
  CHECK(test::error_of([&] { write_mesh(mesh, folder / "out.msh", nullptr, runner); }).code == ErrorCode::Cancelled);
  CHECK(folder.file_count() == 0);
  CHECK(test::error_of([&] { compute_quality(mesh, nullptr, runner); }).code == ErrorCode::Cancelled);
  CHECK(test::error_of([&] { validate_mesh(mesh, runner); }).code == ErrorCode::Cancelled);
}
