// Ranks that adapt a mesh together and fail: with the same error on all of them, whichever of them it was.
#include <atomic>
#include <catch2/catch.hpp>
#include <new>
#include <random>

#include "tests/adapt/on_ranks.hpp"
#include "tests/support/sanitized.hpp"
#include "tetloom/adapt.hpp"

using namespace tetloom;
using test::in_parts, test::layered, test::on_ranks;

namespace {

/// Ranks that are given what `change` makes another on the second of them are refused, all of them.
void check_differs(const std::function<void(Mesh&, AdaptOptions&)>& change) {
  std::vector<AdaptResult> results(2);
  on_simulated_ranks(2, [&](Communicator& communicator) {
    Mesh cube = test::make_unit_cube(4);
    cube.cell_fields = {{"load", 1, std::vector<double>(cube.tet_to_vert.size(), 1)}};
    AdaptOptions options;
    options.transfer = {"load"};
    if (communicator.rank() == 1) change(cube, options);
    const auto metric = [](const Vec3&) { return adapt::isotropic(0.3); };
    results[static_cast<std::size_t>(communicator.rank())] = adapt_mesh_on_ranks(cube, metric, options, communicator);
  });
  for (const AdaptResult& result : results) {
    REQUIRE(result.errors.size() == 1);
    CHECK(result.errors[0].code == ErrorCode::InvalidArgument);
    CHECK(result.errors[0].message.find("not given the same") != std::string::npos);
  }
}

}  // namespace

TEST_CASE("what one rank cannot do fails on all of them alike", "[adapt][ranks]") {
  const Mesh cube = test::make_unit_cube(4);
  // Asked for on one rank alone, late enough to be inside of a round.
  for (const int failing : {0, 1, 2}) {
    for (const int last : {1, 500, 1500}) {
      CAPTURE(failing, last);
      std::vector<AdaptResult> results(3);
      on_simulated_ranks(3, [&](Communicator& communicator) {
        std::atomic<int> asked{0};
        const auto metric = [&, fails = communicator.rank() == failing](const Vec3&) {
          if (fails && ++asked >= last) throw std::bad_alloc();
          return adapt::isotropic(0.12);
        };
        results[static_cast<std::size_t>(communicator.rank())] =
            adapt_mesh_on_ranks(cube, metric, in_parts(800), communicator);
      });
      for (const AdaptResult& result : results) {
        CHECK(result.status == AdaptStatus::Failed);
        CHECK(result.mesh.points.empty());
        REQUIRE(result.errors.size() == 1);
        CHECK(result.errors[0].code == ErrorCode::OutOfMemory);
        CHECK(result.errors[0].message == results[0].errors[0].message);
      }
    }
  }
}

TEST_CASE("whatever a rank's metric throws is an error of the run, the same on all ranks", "[adapt][ranks]") {
  const Mesh mesh = test::make_unit_cube(4);
  for (const int ranks : {1, 2, 3})
    for (int failing = 0; failing < ranks; ++failing) {
      CAPTURE(ranks, failing);
      std::vector<AdaptResult> results(static_cast<std::size_t>(ranks));
      on_simulated_ranks(ranks, [&](Communicator& communicator) {
        const int rank = communicator.rank();
        std::atomic<int> asked{0};
        const auto metric = [&](const Vec3& x) {
          if (rank == failing && ++asked > 500) throw 7;
          return layered(x);
        };
        results[static_cast<std::size_t>(rank)] = adapt_mesh_on_ranks(mesh, metric, in_parts(500), communicator);
      });
      for (const AdaptResult& result : results) {
        CHECK(result.status == AdaptStatus::Failed);
        REQUIRE(result.errors.size() == 1);
        CHECK(result.errors[0].code == ErrorCode::Internal);
        CHECK(result.errors[0].message == "unexpected error of an unknown type");
        CHECK(result.mesh.points.empty());
      }
    }
}

TEST_CASE("bad input is told alike by all ranks", "[adapt][ranks]") {
  const auto metric = [](const Vec3&) { return adapt::isotropic(0.3); };
  Mesh cube = test::make_unit_cube(3);
  cube.tri_to_entity[3] = kNone;
  for (const AdaptResult& result : on_ranks(2, cube, metric, {})) {
    REQUIRE(result.errors.size() == 1);
    CHECK(result.errors[0].code == ErrorCode::InputUnsuitable);
    CHECK(result.errors[0].point);
  }
  AdaptOptions options;
  options.threads = -1;
  for (const AdaptResult& result : on_ranks(2, test::make_unit_cube(2), metric, options)) {
    REQUIRE(result.errors.size() == 1);
    CHECK(result.errors[0].code == ErrorCode::InvalidArgument);
  }
}

TEST_CASE("ranks that are given different meshes, fields or options are refused", "[adapt][ranks]") {
  check_differs([](Mesh& mesh, AdaptOptions&) {
    mesh.tet_to_vert.pop_back(), mesh.tet_to_entity.pop_back(), mesh.cell_fields[0].values.pop_back();
  });
  check_differs([](Mesh& mesh, AdaptOptions&) { mesh.points[30].x += 1e-9; });
  check_differs([](Mesh& mesh, AdaptOptions&) { std::swap(mesh.tet_to_vert[0], mesh.tet_to_vert[1]); });
  check_differs([](Mesh& mesh, AdaptOptions&) { ++mesh.tri_to_entity[5]; });
  check_differs([](Mesh& mesh, AdaptOptions&) { mesh.point_to_entity[30] = ModelEntity(2, 0); });
  check_differs([](Mesh& mesh, AdaptOptions&) { ++mesh.edge_to_entity[2]; });
  check_differs([](Mesh& mesh, AdaptOptions&) { mesh.cell_fields[0].values[7] = 3; });
  check_differs([](Mesh&, AdaptOptions& options) { options.quality_floor = 0.2; });
  check_differs([](Mesh&, AdaptOptions& options) { options.transfer.clear(); });
}

TEST_CASE("stopped by the host of one rank at any moment, all ranks are cancelled", "[adapt][ranks]") {
  const Mesh cube = test::make_unit_cube(4);
  const auto metric = [](const Vec3&) { return adapt::isotropic(0.12); };
  std::atomic<int> looks{0};
  const auto host_of = [&](int stopping, int last) {
    return [&, stopping, last](int rank) {
      Host host;
      if (rank == stopping) host.wants_stop = [&, last] { return ++looks > last; };
      return host;
    };
  };
  for (const AdaptResult& result : on_ranks(3, cube, metric, in_parts(800), host_of(0, 1 << 30)))
    REQUIRE(result.status == AdaptStatus::Ok);
  const int all = looks;
  REQUIRE(all > 100);
  std::mt19937 random(5);
  int cancelled = 0;
  // A busy machine may have come to an end before so many looks.
  for (int i = 0; i < 15 && (cancelled <= 2 || !test::kSanitized); ++i) {
    const int last = static_cast<int>(random() % static_cast<unsigned>(all)), stopping = i % 3;
    CAPTURE(last, stopping, all);
    looks = 0;
    const auto results = on_ranks(3, cube, metric, in_parts(800), host_of(stopping, last));
    for (const AdaptResult& result : results) {
      CHECK(result.status == results[0].status);
      CHECK(result.status != AdaptStatus::Failed);
      if (result.status == AdaptStatus::Cancelled) CHECK(result.mesh.points.empty());
    }
    cancelled += results[0].status == AdaptStatus::Cancelled;
  }
  CHECK(cancelled > 2);
}
