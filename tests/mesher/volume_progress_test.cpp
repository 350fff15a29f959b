// Progress while volumes are filled, and stopping.
#include <algorithm>
#include <chrono>
#include <ctime>
#include <thread>

#include "mesher/volume/volume_mesher.hpp"
#include "tests/mesher/volume_surfaces.hpp"
#include "tests/support/sanitized.hpp"
#include "tetloom/tasks.hpp"

using namespace tetloom;
using namespace tetloom::volume_tests;

TEST_CASE("progress within one volume runs in steps from nothing to the estimated tets, on any number of threads") {
  const Surface ball = ball_surface(6, {0, 0, 0}, 3, [](const Vec3&) { return 1.0; });
  const SizeField sizes = SizeField::uniform(test::kSanitized ? 0.035 : 0.02);
  std::set<std::uint64_t> totals;
  for (const int threads : {1, 2}) {
    CAPTURE(threads);
    std::vector<ProgressEvent> events;
    Host host;
    host.progress = [&](const ProgressEvent& event) {
      events.push_back(event);
      return true;
    };
    const VolumeMesh mesh = fill_volume(ball.input(sizes), {}, TaskRunner(threads, host));
    REQUIRE(events.size() > 3);  // the host hears of it at most every few milliseconds
    CHECK(events.front().done == 0);
    for (std::size_t i = 1; i < events.size(); ++i) {
      CHECK(events[i].stage == Stage::Volume);
      CHECK(events[i].total == events[0].total);
      CHECK(events[i].done > events[i - 1].done);
    }
    CHECK(events.back().done == events.back().total);
    CHECK(events.back().entity == ModelEntity(3, 3));
    CHECK(double(events.back().total) == Approx(double(mesh.tet_to_vert.size())).epsilon(0.1));
    totals.insert(events.back().total);
  }
  CHECK(totals.size() == 1);
}

TEST_CASE("progress reaches its end where TetGen has to help, and where a region fails") {
  Surface surface = cube_surface(3);
  for (const bool fails : {false, true}) {
    CAPTURE(fails);
    if (fails) {
      for (FaceSides& sides : surface.tri_to_sides) std::swap(sides.front, sides.back);
    }
    ProgressEvent last;
    Host host;
    host.progress = [&](const ProgressEvent& event) {
      last = event;
      return true;
    };
    const SizeField sizes = SizeField::uniform(0.3);
    const VolumeMesh mesh = fill_volume(surface.input(sizes), {TETLOOM_WORKER, !fails}, TaskRunner(1, host));
    CHECK(mesh.errors.empty() != fails);
    CHECK(last.total > 0);
    CHECK(last.done == last.total);
  }
}

TEST_CASE("filling stops within a second of being told to, whenever that is") {
  const Surface ball = ball_surface(7, {0, 0, 0}, 0, [](const Vec3&) { return 1.0; });
  const SizeField sizes = SizeField::uniform(test::kSanitized ? 0.04 : 0.013);  // about two million tets
  std::size_t stopped = 0;
  for (int i = 1; i <= 12; ++i) {
    CancelToken token;
    std::clock_t told = 0;  // processor time, which a busy machine does not change
    std::jthread canceller([&] {
      std::this_thread::sleep_for(std::chrono::milliseconds(50 * i));
      told = std::clock();
      token.cancel();
    });
    try {
      fill_volume(ball.input(sizes), {}, TaskRunner(1, {{}, &token}));
    } catch (const Error& error) {
      CHECK(error.code() == ErrorCode::Cancelled);
      ++stopped;
    }
    canceller.join();
    CHECK(static_cast<double>(std::clock() - told) < CLOCKS_PER_SEC);
    if (stopped < static_cast<std::size_t>(i)) break;
  }
  CHECK(stopped > 0);
}
