// A host that stops filling in parts at any moment.
#include <atomic>
#include <chrono>
#include <thread>

#include "mesher/volume/volume_mesher.hpp"
#include "tests/mesher/parts_fixtures.hpp"
#include "tests/support/sanitized.hpp"
#include "tetloom/tasks.hpp"

using namespace tetloom;
using namespace tetloom::volume_tests;

namespace {

constexpr std::uint64_t kNever = std::numeric_limits<std::uint64_t>::max();

struct Polled {
  std::uint64_t polls = 0;
  bool cancelled = false;
  VolumeMesh mesh;
};

// Filled by a host that says stop from when it is asked for the `last`th time on.
Polled fill_polled(const PartsCase& one, std::uint64_t last, int threads) {
  std::atomic<std::uint64_t> polls{0};  // of all threads
  Host host;
  host.wants_stop = [&] { return polls.fetch_add(1) + 1 >= last; };
  Polled result;
  try {
    result.mesh = fill_case(one, one.tets_per_part, TaskRunner(threads, host));
  } catch (const Error& error) {
    REQUIRE(error.code() == ErrorCode::Cancelled);
    result.cancelled = true;
  }
  result.polls = polls;
  return result;
}

std::vector<PartsCase> cases() {
  std::vector<PartsCase> list;
  list.push_back({"ball", round_ball(3), SizeField::uniform(0.2), 600});
  list.push_back({"graded", round_ball(3), growing_sizes(0.14, 0.3), 600});
  list.push_back({"prisms", ball_with_prisms(3, {{-0.4, 0, 0}, {0.4, 0.1, 0}}, 0.2), SizeField::uniform(0.2), 600});
  return list;
}

}  // namespace

TEST_CASE("stopped at any moment, filling in parts ends as cancelled; else it is as if nobody had asked") {
  const unsigned seed = 2027;
  CAPTURE(seed);
  std::mt19937_64 random(seed);
  for (const PartsCase& one : cases()) {
    INFO(one.name);
    const Polled whole = fill_polled(one, kNever, 1);
    REQUIRE(whole.mesh.errors.empty());
    REQUIRE(whole.mesh.figures.parts.parts > 3);
    REQUIRE(whole.mesh.figures.parts.given_up == 0);
    CAPTURE(whole.polls);
    const int runs = test::kSanitized ? 6 : 67;
    int cancelled = 0, completed = 0;
    for (int i = 0; i < runs; ++i) {
      const std::uint64_t last = 1 + random() % (whole.polls + whole.polls / 4);
      CAPTURE(i, last);
      const Polled run = fill_polled(one, last, 1 + i % 4);
      (run.cancelled ? cancelled : completed) += 1;
      if (!run.cancelled) CHECK(same_mesh(run.mesh, whole.mesh));
    }
    CHECK(cancelled > 0);
    CHECK((completed > 0 || test::kSanitized));
    CHECK(same_mesh(fill_case(one, 3), whole.mesh));
  }
}

TEST_CASE("stopped by a token after any time, filling in parts ends as cancelled or with the whole mesh") {
  const unsigned seed = 78;
  CAPTURE(seed);
  std::mt19937_64 random(seed);
  for (const PartsCase& one : cases()) {
    INFO(one.name);
    const auto start = std::chrono::steady_clock::now();
    const VolumeMesh whole = fill_case(one, 2);
    const auto span = std::chrono::steady_clock::now() - start;
    for (int i = 0; i < (test::kSanitized ? 2 : 10); ++i) {
      CAPTURE(i);
      CancelToken token;
      std::jthread stopper([&, after = span * (random() % 110) / 100] {
        std::this_thread::sleep_for(after);
        token.cancel();
      });
      try {
        const VolumeMesh mesh = fill_case(one, one.tets_per_part, TaskRunner(2, {{}, &token}));
        CHECK(same_mesh(mesh, whole));
      } catch (const Error& error) {
        CHECK(error.code() == ErrorCode::Cancelled);
      }
    }
  }
}
