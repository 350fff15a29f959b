// A host that stops the way from a model to files of parts at any moment.
#include <atomic>
#include <catch2/catch.hpp>
#include <filesystem>
#include <limits>
#include <random>

#include "tests/support/analytic_model.hpp"
#include "tests/support/sanitized.hpp"
#include "tests/support/temporary_folder.hpp"
#include "tests/threading/communicators.hpp"
#include "tetloom/check.hpp"
#include "tetloom/mesh.hpp"
#include "tetloom/partition.hpp"
#include "tetloom/tasks.hpp"

using namespace tetloom;
namespace fs = std::filesystem;

namespace {

constexpr std::uint64_t kNever = std::numeric_limits<std::uint64_t>::max();

MeshOptions options_of(int threads, double tets_per_part = 1500) {
  MeshOptions options;
  options.sizes.size = 0.11;
  options.sizes.curvature = 12;
  options.tets_per_part = tets_per_part, options.threads = threads;
  return options;
}

std::unique_ptr<GeometricModel> two_bodies() {
  std::vector<std::shared_ptr<const GeometricModel>> bodies{test_models::make_box({0, 0, 0}, {1, 1, 1}),
                                                            test_models::make_sphere({3, 0, 0}, 0.6)};
  return test_models::combine(bodies);
}

struct Outcome {
  std::uint64_t polls = 0;
  MeshStatus status = MeshStatus::Failed;
  bool written = false;
  std::string digest;  ///< of what was written
};

/// Meshes and writes to `folder`/mesh.pvtu for a host that says stop from when it is asked for the `last`th time on.
Outcome mesh_and_write(const GeometricModel& model, const test::TemporaryFolder& folder, std::uint64_t last,
                       int threads) {
  std::atomic<std::uint64_t> polls{0};  // of all threads
  Host host;
  host.wants_stop = [&] { return polls.fetch_add(1) + 1 >= last; };
  const auto communicator = make_communicator();
  const MeshInPartsResult result = make_mesh_in_parts(model, options_of(threads), *communicator, host);
  Outcome outcome;
  outcome.status = result.run.status;
  if (result.run.status == MeshStatus::Ok) {
    REQUIRE(result.mesh);
    try {
      write_parts(*result.mesh, folder / "mesh.pvtu", TaskRunner(threads, host));
      outcome.written = true;
      outcome.digest = mesh_digest(gather_mesh(*result.mesh, TaskRunner(threads)));
    } catch (const Error& error) {
      REQUIRE(error.code() == ErrorCode::Cancelled);
    }
  } else {
    CHECK_FALSE(result.mesh);
    REQUIRE(result.run.errors.size() == 1);
    CHECK(result.run.errors[0].code == ErrorCode::Cancelled);
  }
  outcome.polls = polls;
  return outcome;
}

void check_cancels(int runs, unsigned seed) {
  CAPTURE(seed);
  const auto model = two_bodies();
  const Outcome whole = mesh_and_write(*model, test::TemporaryFolder(), kNever, 1);
  REQUIRE(whole.written);
  CAPTURE(whole.polls);
  std::mt19937_64 random(seed);
  int cancelled = 0, in_writing = 0;
  for (int i = 0; i < runs; ++i) {
    // Writing asks much less often than meshing: every fifth run is stopped there.
    const std::uint64_t from = i % 5 == 0 ? whole.polls - whole.polls / 50 : 1;
    const std::uint64_t last = from + random() % (whole.polls + 1 - from);
    CAPTURE(i, last);
    const test::TemporaryFolder folder;
    const Outcome run = mesh_and_write(*model, folder, last, 1 + i % 3);
    if (run.written) {
      CHECK(run.digest == whole.digest);
      continue;
    }
    ++cancelled;
    if (run.status == MeshStatus::Ok) {
      ++in_writing;
    } else {
      CHECK(run.status == MeshStatus::Cancelled);
    }
    CHECK(fs::is_empty(folder.path()));
  }
  CHECK(cancelled > runs / 2);
  CHECK((in_writing > 0 || runs < 50));
  CHECK(mesh_and_write(*model, test::TemporaryFolder(), kNever, 2).digest == whole.digest);
}

}  // namespace

TEST_CASE("stopped at any moment, meshing and writing end as cancelled, with nothing on disk") {
  check_cancels(test::kSanitized ? 6 : 200, 2027);
}

TEST_CASE("a run that was stopped tells the seconds of its stages so far") {
  const auto model = two_bodies();
  for (const Stage last : {Stage::SizeField, Stage::Faces, Stage::Intersections, Stage::Volume}) {
    INFO(to_string(last));
    Host host;
    host.progress = [&](const ProgressEvent& event) { return event.stage != last; };
    const MeshResult result = make_mesh(*model, options_of(2), host);
    CHECK(result.status == MeshStatus::Cancelled);
    CHECK(result.seconds.size_field > 0);
    CHECK((result.seconds.surface > 0) == (last != Stage::SizeField));
    CHECK((result.seconds.volume > 0) == (last == Stage::Volume));
  }
}

TEST_CASE("for any size of the parts the mesh does not depend on the number of threads") {
  const auto model = two_bodies();
  for (const double tets_per_part : {800.0, 2500.0, HUGE_VAL}) {
    CAPTURE(tets_per_part);
    const MeshResult one = make_mesh(*model, options_of(1, tets_per_part));
    REQUIRE(one.status == MeshStatus::Ok);
    CHECK((one.filling.parts.parts > 1) == (tets_per_part < 1e6));
    for (const int threads : {2, 4, 7})
      CHECK(mesh_digest(make_mesh(*model, options_of(threads, tets_per_part)).mesh) == mesh_digest(one.mesh));
  }
}
