// A host that stops a filling at any moment.
#include <atomic>
#include <chrono>
#include <limits>
#include <random>
#include <thread>

#include "mesher/volume/volume_mesher.hpp"
#include "tests/mesher/volume_surfaces.hpp"
#include "tests/support/sanitized.hpp"
#include "tetloom/tasks.hpp"

using namespace tetloom;
using namespace tetloom::volume_tests;

namespace {

constexpr std::uint64_t kNever = std::numeric_limits<std::uint64_t>::max();

// A ball with a twisted prism inside, so that points are put to recover its triangles.
Surface ball_with_prism() {
  Surface surface = ball(2);
  Surface prism;
  for (std::uint32_t k = 0; k < 6; ++k) {
    const double angle = 2.0943951023931953 * (k % 3) + (k < 3 ? 0 : -0.5);
    prism.points.push_back({0.3 * std::cos(angle), 0.3 * std::sin(angle), k < 3 ? -0.2 : 0.2});
  }
  prism.add({0, 2, 1}, 0, kOutside, 1), prism.add({3, 4, 5}, 0, kOutside, 1);
  for (std::uint32_t k = 0; k < 3; ++k) {
    const std::uint32_t next = (k + 1) % 3;
    prism.add({k, next, 3 + k}, 0, kOutside, 2), prism.add({next, 3 + next, 3 + k}, 0, kOutside, 2);
  }
  surface.append(prism);
  return surface;
}

struct Polled {
  std::uint64_t polls = 0;
  bool cancelled = false;
  VolumeMesh mesh;
};
// Filled by a host that says stop when it is asked for the `last`th time.
Polled fill_polled(const Surface& surface, std::uint64_t last, int threads) {
  const SizeField sizes = SizeField::uniform(0.12);
  std::atomic<std::uint64_t> polls{0};
  Host host;
  host.wants_stop = [&] { return polls.fetch_add(1) + 1 >= last; };
  Polled result;
  try {
    result.mesh = fill_volume(surface.input(sizes), {}, TaskRunner(threads, host));
  } catch (const Error& error) {
    REQUIRE(error.code() == ErrorCode::Cancelled);
    result.cancelled = true;
  }
  result.polls = polls;
  return result;
}

bool same_mesh(const VolumeMesh& a, const VolumeMesh& b) {
  return a.new_points == b.new_points && a.tet_to_vert == b.tet_to_vert && a.tet_to_region == b.tet_to_region;
}

}  // namespace

TEST_CASE("stopped at any moment, filling ends as cancelled; else it is as if nobody had asked") {
  const unsigned seed = 2024;
  CAPTURE(seed);
  std::mt19937_64 random(seed);
  for (const auto& [surface, runs] : {std::pair(ball_with_prism(), 20), std::pair(ball(3), 180)}) {
    const Polled whole = fill_polled(surface, kNever, 1);
    for (const Diagnostic& error : whole.mesh.errors) UNSCOPED_INFO(error.message);
    REQUIRE(whole.mesh.errors.empty());
    check_filling(surface, whole.mesh);
    CAPTURE(whole.polls, whole.mesh.figures.recovery_points);
    int cancelled = 0, completed = 0;
    for (int i = 0; i < (test::kSanitized ? runs / 10 : runs); ++i) {
      const std::uint64_t last = 1 + random() % (whole.polls + whole.polls / 4);
      CAPTURE(i, last);
      const Polled run = fill_polled(surface, last, 1 + i % 2);
      (run.cancelled ? cancelled : completed) += 1;
      if (i % 2 == 0) CHECK(run.cancelled == (last <= whole.polls));
      if (run.cancelled) CHECK(run.polls < last + 10);  // each thread may ask a few times more on its way out
      if (!run.cancelled) CHECK(same_mesh(run.mesh, whole.mesh));
    }
    CHECK(cancelled > 0);
    CHECK((completed > 0 || test::kSanitized));
  }
}

TEST_CASE("stopped by a token after any time, filling ends as cancelled or with the whole mesh") {
  const unsigned seed = 77;
  CAPTURE(seed);
  std::mt19937_64 random(seed);
  const Surface surface = ball_with_prism();
  const auto start = std::chrono::steady_clock::now();
  const Polled whole = fill_polled(surface, kNever, 2);
  const auto span = std::chrono::steady_clock::now() - start;
  const SizeField sizes = SizeField::uniform(0.12);
  for (int i = 0; i < (test::kSanitized ? 5 : 20); ++i) {
    CAPTURE(i);
    CancelToken token;
    std::jthread stopper([&, after = span * (random() % 110) / 100] {
      std::this_thread::sleep_for(after);
      token.cancel();
    });
    try {
      const VolumeMesh mesh = fill_volume(surface.input(sizes), {}, TaskRunner(2, {{}, &token}));
      CHECK(same_mesh(mesh, whole.mesh));
    } catch (const Error& error) {
      CHECK(error.code() == ErrorCode::Cancelled);
    }
  }
}
