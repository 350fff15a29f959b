// Ranks that make a surface together: the surface of one process, and one outcome where one of them fails.
#include <atomic>
#include <catch2/catch.hpp>
#include <limits>
#include <new>
#include <random>
#include <stdexcept>

#include "mesher/mesh_run_detail.hpp"
#include "mesher/surface/surface_mesher.hpp"
#include "mesher/volume/volume_mesher.hpp"
#include "tests/support/analytic_model.hpp"
#include "tests/support/sanitized.hpp"
#include "tests/threading/communicators.hpp"
#include "tetloom/mesh.hpp"
#include "tetloom/tasks.hpp"

using namespace tetloom;
using namespace tetloom::test_models;

namespace {

/// A model that tells whenever it is asked for the shape of a face.
class ToldModel : public GeometricModel {
 public:
  ToldModel(const GeometricModel& model, std::function<void(ModelFaceId)> tell)
      : model_(model), tell_(std::move(tell)) {
    topology_ = model.topology();
    for (int dim = 0; dim < 4; ++dim)
      for (std::size_t i = 0; i < topology_.count(dim); ++i)
        attributes_[static_cast<std::size_t>(dim)].push_back(model.attributes({dim, static_cast<std::uint32_t>(i)}));
    bounding_box_ = model.bounding_box();
  }
  Vec3 vertex_point(ModelVertexId id) const override { return model_.vertex_point(id); }
  std::unique_ptr<EdgeGeometry> edge_geometry(ModelEdgeId id) const override { return model_.edge_geometry(id); }
  std::unique_ptr<FaceGeometry> face_geometry(ModelFaceId id) const override {
    tell_(id);
    return model_.face_geometry(id);
  }
  double area(ModelFaceId id) const override { return model_.area(id); }
  double volume(ModelRegionId id) const override { return model_.volume(id); }

 private:
  const GeometricModel& model_;
  std::function<void(ModelFaceId)> tell_;
};

class NoVolume : public ToldModel {
 public:
  explicit NoVolume(const GeometricModel& model) : ToldModel(model, [](ModelFaceId) {}) {}
  double volume(ModelRegionId) const override { throw Error(ErrorCode::VolumeFailed, "the volume cannot be told"); }
};

std::unique_ptr<GeometricModel> three_bodies() {
  std::vector<std::shared_ptr<const GeometricModel>> bodies{make_torus(1, 0.4), make_box({2, 0, 0}, {3, 1, 1}),
                                                            make_cone(0.5, 2)};
  return combine(bodies);
}

/// A surface alone, by all ranks; nothing is filled.
MeshResult mesh_together(const GeometricModel& model, const MeshOptions& options, Communicator& communicator,
                         const Host& host = {}) {
  VolumeUse nothing;
  nothing.take = [](VolumeParts&&, Mesh&, const SharedWork&) {};
  return run_mesh(model, options, host, nothing, &communicator);
}

MeshOptions of_surface(const SizeOptions& sizes, int threads = 2) {
  MeshOptions options;
  options.sizes = sizes;
  options.threads = threads;
  options.surface_only = true;
  return options;
}

void check_same(const MeshResult& one, const MeshResult& other) {
  CHECK(one.status == other.status);
  CHECK(one.mesh.points == other.mesh.points);
  CHECK(one.mesh.point_to_entity == other.mesh.point_to_entity);
  CHECK(one.mesh.edge_to_vert == other.mesh.edge_to_vert);
  CHECK(one.mesh.tri_to_vert == other.mesh.tri_to_vert);
  CHECK(one.mesh.tri_to_entity == other.mesh.tri_to_entity);
  CHECK(one.refinement.rounds == other.refinement.rounds);
  CHECK(one.refinement.crossings == other.refinement.crossings);
  CHECK(one.refinement.narrow_places == other.refinement.narrow_places);
  for (const Vec3& x : one.mesh.points) REQUIRE(one.sizes.size_at(x) == other.sizes.size_at(x));
  REQUIRE(one.errors.size() == other.errors.size());
  REQUIRE(one.warnings.size() == other.warnings.size());
  for (std::size_t i = 0; i < one.errors.size(); ++i) {
    CHECK(one.errors[i].code == other.errors[i].code);
    CHECK(one.errors[i].message == other.errors[i].message);
    CHECK(one.errors[i].entities.size() == other.errors[i].entities.size());
    CHECK(one.errors[i].point == other.errors[i].point);
  }
}

MeshResult check_like_one_process(const GeometricModel& model, const SizeOptions& sizes) {
  const auto communicator = make_communicator();
  MeshResult alone = make_mesh(model, of_surface(sizes));
  for (const int threads : {1, 3}) check_same(mesh_together(model, of_surface(sizes, threads), *communicator), alone);
  return alone;
}

SizeOptions sizes_of(double size) {
  SizeOptions sizes;
  sizes.size = size;
  return sizes;
}

}  // namespace

TEST_CASE("the surface that ranks make together is that of one process") {
  CHECK(check_like_one_process(*three_bodies(), sizes_of(0.1)).mesh.tri_to_vert.size() > 1000);
  CHECK(check_like_one_process(*make_plate(2, 1), sizes_of(0.1)).mesh.tri_to_vert.size() > 100);
}

TEST_CASE("ranks share the pieces, zones and junctions of large faces") {
  std::vector<std::shared_ptr<const GeometricModel>> bodies{make_sphere({}, 0.5), make_box({2, 0, 0}, {2.2, 0.2, 0.2})};
  CHECK(check_like_one_process(*combine(bodies), sizes_of(0.012)).mesh.tri_to_vert.size() > 40000);
}

TEST_CASE("ranks share the work on sizes that vary") {
  SizeOptions sizes = sizes_of(0.3);
  sizes.curvature = 16;
  sizes.proximity = 2;
  check_like_one_process(*three_bodies(), sizes);
  sizes.callback = [](const Vec3& x) { return 0.1 + 0.1 * norm(x); };
  check_like_one_process(*three_bodies(), sizes);
}

TEST_CASE("ranks agree on what is made anew with smaller sizes") {
  std::vector<std::shared_ptr<const GeometricModel>> bodies{make_box({0, 0, 0}, {1, 1, 0.02}), make_torus(3, 0.2)};
  const MeshResult result = check_like_one_process(*combine(bodies), sizes_of(0.3));
  CHECK(result.refinement.rounds > 0);
  CHECK(result.refinement.narrow_places > 0);
}

TEST_CASE("a face that fails is told alike by all ranks, whichever had it") {
  const auto communicator = make_communicator();
  const auto bodies = three_bodies();
  for (std::uint32_t face = 0; face < bodies->topology().face_count(); face += 3) {
    CAPTURE(face);
    const ToldModel model(*bodies, [&](ModelFaceId id) {
      if (id == ModelFaceId(face)) throw Error(ErrorCode::FaceFailed, "planted");
    });
    const MeshResult alone = make_mesh(model, of_surface(sizes_of(0.2)));
    CHECK(alone.status == MeshStatus::Failed);
    check_same(mesh_together(model, of_surface(sizes_of(0.2)), *communicator), alone);
  }
}

TEST_CASE("where one rank runs out of memory, all of them say so") {
  const auto communicator = make_communicator();
  const auto bodies = three_bodies();
  SizeOptions sizes = sizes_of(0.2);
  sizes.curvature = 20;
  for (int failing = 0; failing < communicator->rank_count(); ++failing) {
    for (int last : {1, 2, 3, 5, 8, 13}) {
      CAPTURE(failing, last);
      std::atomic<int> asked{0};
      const ToldModel model(*bodies, [&](ModelFaceId) {
        if (communicator->rank() == failing && ++asked >= last) throw std::bad_alloc();
      });
      const MeshResult result = mesh_together(model, of_surface(sizes), *communicator);
      std::int64_t reached[] = {asked >= last ? 1 : 0};
      communicator->sum(reached);
      if (reached[0] == 0) continue;
      CHECK(result.status == MeshStatus::Failed);
      REQUIRE(result.errors.size() == 1);
      CHECK(result.errors[0].code == ErrorCode::OutOfMemory);
    }
  }
}

TEST_CASE("whatever a rank throws at a face is an error of the run, the same on all ranks") {
  const auto communicator = make_communicator();
  const auto bodies = three_bodies();
  const std::vector<std::pair<std::function<void()>, std::string>> throws{
      {[] { throw std::length_error("too long"); }, "unexpected error: too long"},
      {[] { throw std::runtime_error("odd"); }, "unexpected error: odd"},
      {[] { throw 7; }, "unexpected error of an unknown type"}};
  for (int failing = 0; failing < communicator->rank_count(); ++failing) {
    for (const auto& [fail, message] : throws) {
      CAPTURE(failing, message);
      const ToldModel model(*bodies, [&, fail = fail](ModelFaceId) {
        if (communicator->rank() == failing) fail();
      });
      MeshOptions options = of_surface(sizes_of(0.3));
      options.surface_only = false;
      for (const MeshResult& result :
           {make_mesh_on_ranks(model, options, *communicator), make_mesh_in_parts(model, options, *communicator).run}) {
        CHECK(result.status == MeshStatus::Failed);
        REQUIRE(result.errors.size() == 1);
        CHECK(result.errors[0].code == ErrorCode::Internal);
        CHECK(result.errors[0].message == message);
      }
    }
  }
}

TEST_CASE("what one rank throws late, in the volume stage as well, ends all of them") {
  const auto communicator = make_communicator();
  const auto bodies = three_bodies();
  MeshOptions options = of_surface(sizes_of(0.15));
  options.surface_only = false, options.tets_per_part = 2000;
  for (int failing = 0; failing < communicator->rank_count(); ++failing) {
    CAPTURE(failing);
    std::atomic<int> asked{0}, last{std::numeric_limits<int>::max()};
    const ToldModel model(*bodies, [&](ModelFaceId) {
      if (communicator->rank() == failing && ++asked >= last) throw std::length_error("too long");
    });
    REQUIRE(make_mesh_in_parts(model, options, *communicator).run.status == MeshStatus::Ok);
    last = std::max(1, asked.exchange(0) * 9 / 10);
    const MeshResult result = make_mesh_in_parts(model, options, *communicator).run;
    std::int64_t reached[] = {asked >= last ? 1 : 0};
    communicator->sum(reached);
    REQUIRE(reached[0] == 1);
    CHECK(result.status == MeshStatus::Failed);
    REQUIRE(result.errors.size() == 1);
    CHECK(result.errors[0].code == ErrorCode::Internal);
    CHECK(result.errors[0].message == "unexpected error: too long");
  }
}

namespace {

/// Stops one rank after the other at random moments, and looks whether all ranks say the same.
void check_stops(const MeshOptions& options, Communicator& communicator, int runs) {
  const unsigned seed = 41;
  CAPTURE(seed);
  std::mt19937_64 random(seed);
  const auto model = three_bodies();
  const auto run = [&](int stopping, std::uint64_t last, std::uint64_t& polls) {
    std::atomic<std::uint64_t> asked{0};
    Host host;
    if (communicator.rank() == stopping) host.wants_stop = [&] { return asked.fetch_add(1) + 1 >= last; };
    MeshResult result = options.surface_only ? mesh_together(*model, options, communicator, host)
                                             : make_mesh_in_parts(*model, options, communicator, host).run;
    polls = asked;
    return result;
  };
  std::uint64_t polls = 0;
  const MeshResult whole = run(0, std::numeric_limits<std::uint64_t>::max(), polls);
  REQUIRE(whole.status == MeshStatus::Ok);
  std::int64_t all_polls[] = {static_cast<std::int64_t>(polls)};
  communicator.sum(all_polls);
  int cancelled = 0;
  for (int i = 0; i < runs; ++i) {
    const std::uint64_t last = 1 + random() % (static_cast<std::uint64_t>(all_polls[0]) * 5 / 4);
    const int stopping = i % communicator.rank_count();
    CAPTURE(i, last, stopping);
    const MeshResult result = run(stopping, last, polls);
    std::int64_t statuses[] = {result.status == MeshStatus::Ok, result.status == MeshStatus::Cancelled};
    communicator.sum(statuses);
    CHECK((statuses[0] == communicator.rank_count() || statuses[1] == communicator.rank_count()));
    for (const Diagnostic& error : result.errors) CHECK(error.code == ErrorCode::Cancelled);
    if (result.status == MeshStatus::Cancelled) ++cancelled;
    if (result.status == MeshStatus::Ok) CHECK(result.mesh.points == whole.mesh.points);
  }
  CHECK(cancelled > 0);
}

}  // namespace

TEST_CASE("stopped by the host of one rank, all ranks are cancelled, or none and the surface is whole") {
  SizeOptions sizes = sizes_of(0.3);
  sizes.curvature = 10;
  check_stops(of_surface(sizes), *make_communicator(), test::kSanitized ? 6 : 30);
}

TEST_CASE("stopped by the host of one rank, all ranks are cancelled, or none and the volume is filled") {
  MeshOptions options = of_surface(sizes_of(0.15));
  options.surface_only = false;
  options.tets_per_part = 3000;
  check_stops(options, *make_communicator(), test::kSanitized ? 4 : 20);
}

TEST_CASE("a model that cannot tell its volume is an error of the run, on all ranks") {
  const auto communicator = make_communicator();
  const auto box = make_box({0, 0, 0}, {1, 1, 1});
  SizeOptions sizes;
  sizes.size = 0.3;
  const MeshResult result = mesh_together(NoVolume(*box), of_surface(sizes), *communicator);
  CHECK(result.status == MeshStatus::Failed);
  CHECK(result.mesh.points.empty());
  REQUIRE(result.errors.size() == 1);
  CHECK(result.errors[0].code == ErrorCode::VolumeFailed);
}
