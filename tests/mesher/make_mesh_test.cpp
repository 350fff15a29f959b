#include <catch2/catch.hpp>
#include <chrono>
#include <cmath>
#include <limits>
#include <numbers>
#include <thread>

#include "tests/mesher/options_of_size.hpp"
#include "tests/support/analytic_model.hpp"
#include "tetloom/check.hpp"
#include "tetloom/mesh.hpp"

using namespace tetloom;
using namespace tetloom::test_models;

namespace {

ErrorCode thrown_code(const GeometricModel& model, const MeshOptions& options) {
  try {
    make_mesh(model, options);
  } catch (const Error& error) {
    return error.code();
  }
  return ErrorCode::Internal;
}

}  // namespace

TEST_CASE("solids are filled, with every tet in its region and every triangle on its face") {
  std::vector<std::shared_ptr<const GeometricModel>> bodies{make_box({0, 0, 0}, {1, 1, 1}), make_sphere({3, 0, 0}, 0.6),
                                                            make_cylinder(0.3, 2)};
  bodies[2] = make_torus(6, 0.5);
  const auto model = combine(bodies);
  MeshOptions options = options_of_size(0.2);
  options.sizes.curvature = 24;
  const MeshResult result = make_mesh(*model, options);
  REQUIRE(result.status == MeshStatus::Ok);
  CHECK(result.errors.empty());
  CHECK(validate_mesh(result.mesh).problems.empty());
  const QualityReport quality = compute_quality(result.mesh, &result.sizes);
  REQUIRE(quality.cells.regions.size() == 3);
  CHECK(quality.cells.regions[0].volume == Approx(1));
  CHECK(quality.tets.volume == Approx(result.model_volume).epsilon(0.01));
  CHECK(quality.tets.inverted == 0);
  CHECK(result.mesh.entities[3].size() == 3);
}

TEST_CASE("a model without regions gives a surface mesh") {
  const MeshResult result = make_mesh(*make_plate(2, 1), options_of_size(0.1));
  CHECK(result.status == MeshStatus::Ok);
  CHECK(result.mesh.tet_to_vert.empty());
  CHECK_FALSE(result.mesh.tri_to_vert.empty());
}

TEST_CASE("the volume improves the surface on the model, or keeps it bit for bit") {
  const auto model = make_torus(1, 0.3);
  MeshOptions options = options_of_size(0.15);
  options.surface_only = true;
  const Mesh surface = make_mesh(*model, options).mesh;
  options.surface_only = false;
  options.improve_surface = false;
  const Mesh kept = make_mesh(*model, options).mesh;
  REQUIRE(kept.tet_to_vert.size() > 0);
  CHECK(kept.tri_to_vert == surface.tri_to_vert);
  CHECK(std::equal(surface.points.begin(), surface.points.end(), kept.points.begin()));
  options.improve_surface = true;
  const MeshResult improved = make_mesh(*model, options);
  CHECK(validate_mesh(improved.mesh).problems.empty());
  CHECK(improved.mesh.tri_to_vert.size() == surface.tri_to_vert.size());
  CHECK(improved.mesh.tri_to_entity == surface.tri_to_entity);
  CHECK(compute_quality(improved.mesh, nullptr).tets.min_dihedral_deg >=
        compute_quality(kept, nullptr).tets.min_dihedral_deg);
}

TEST_CASE("surface_only leaves the solid empty") {
  MeshOptions options = options_of_size(0.3);
  options.surface_only = true;
  const MeshResult result = make_mesh(*make_box({0, 0, 0}, {1, 1, 1}), options);
  CHECK(result.status == MeshStatus::Ok);
  CHECK(result.mesh.tet_to_vert.empty());
}

TEST_CASE("with no size given the size is a fortieth of the diagonal") {
  MeshOptions options;
  options.surface_only = true;
  const auto model = make_box({0, 0, 0}, {1, 1, 1});
  const MeshResult result = make_mesh(*model, options);
  CHECK(result.sizes.largest() == Approx(model->bounding_box().diagonal() / 40));
}

TEST_CASE("the same mesh, bit for bit, on any number of threads") {
  std::vector<std::shared_ptr<const GeometricModel>> bodies{make_box({0, 0, 0}, {1, 1, 1}), make_sphere({3, 0, 0}, 0.6),
                                                            make_torus(8, 0.5)};
  const auto model = combine(bodies);
  MeshOptions options = options_of_size(0.25, 1);
  options.sizes.curvature = 24;
  const std::string reference = mesh_digest(make_mesh(*model, options).mesh);
  for (const int threads : {2, 3, 8}) {
    options.threads = threads;
    CHECK(mesh_digest(make_mesh(*model, options).mesh) == reference);
  }
}

TEST_CASE("curvature keeps the volume of coarse round bodies within a percent") {
  MeshOptions options = options_of_size(10);
  options.sizes.curvature = 24;
  options.sizes.min_size = 0.01;
  for (const auto& model : {make_sphere({0, 0, 0}, 1), make_cylinder(1, 3), make_torus(2, 0.7), make_cone(1, 2)}) {
    const MeshResult result = make_mesh(*model, options);
    REQUIRE(result.status == MeshStatus::Ok);
    CHECK(compute_quality(result.mesh).tets.volume == Approx(result.model_volume).epsilon(0.01));
  }
}

TEST_CASE("options out of range are refused by name") {
  const auto model = make_box({0, 0, 0}, {1, 1, 1});
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  for (const double size : {-1.0, kNan, HUGE_VAL}) {
    CHECK(thrown_code(*model, options_of_size(size)) == ErrorCode::InvalidArgument);
    MeshOptions relative;
    relative.sizes.relative_size = size;
    CHECK(thrown_code(*model, relative) == ErrorCode::InvalidArgument);
  }
  MeshOptions options = options_of_size(0.5);
  options.parts = -1;
  CHECK(thrown_code(*model, options) == ErrorCode::InvalidArgument);
  for (const double tets : {-1.0, kNan}) {
    options = options_of_size(0.5);
    options.tets_per_part = tets;
    CHECK(thrown_code(*model, options) == ErrorCode::InvalidArgument);
  }
  options = options_of_size(0.5);
  options.goals.dihedral = 60.5;
  CHECK(thrown_code(*model, options) == ErrorCode::InvalidArgument);
  options = options_of_size(0.5);
  options.threads = -2;
  CHECK(thrown_code(*model, options) == ErrorCode::InvalidArgument);
  options = options_of_size(0.5);
  options.sizes.gradation = 0;
  CHECK(thrown_code(*model, options) == ErrorCode::InvalidArgument);
  options = options_of_size(0.5);
  options.sizes.entity_sizes.push_back({ModelFaceId(77), 0.1});
  CHECK(thrown_code(*model, options) == ErrorCode::InvalidArgument);
}

TEST_CASE("a size that cannot fit in memory is refused before any work") {
  const MeshResult result = make_mesh(*make_box({0, 0, 0}, {1, 1, 1}), options_of_size(1e-7));
  CHECK(result.status == MeshStatus::Failed);
  REQUIRE(result.errors.size() == 1);
  CHECK(result.errors[0].code == ErrorCode::OutOfMemory);
  CHECK(result.mesh.points.empty());
}

TEST_CASE("the surface mesh is handed back when the volume fails") {
  MeshOptions options = options_of_size(0.3);
  options.volume_worker = "/nonexistent/tetloom-tetgen";
  const MeshResult result = make_mesh(*make_box({0, 0, 0}, {1, 1, 1}), options);
  CHECK(result.status == MeshStatus::Failed);
  REQUIRE_FALSE(result.errors.empty());
  CHECK(result.errors[0].code == ErrorCode::WorkerFailed);
  CHECK_FALSE(result.mesh.tri_to_vert.empty());
  CHECK(result.mesh.tet_to_vert.empty());
}

TEST_CASE("a run can be cancelled at any moment and ends within a second") {
  const auto model = make_torus(2, 0.8);
  for (int i = 0; i < 12; ++i) {
    CancelToken token;
    std::thread canceller([&] {
      std::this_thread::sleep_for(std::chrono::milliseconds(25 * i));
      token.cancel();
    });
    const MeshResult result = make_mesh(*model, options_of_size(0.05), {{}, &token});
    canceller.join();
    INFO("after " << 25 * i << " ms");
    if (result.status == MeshStatus::Ok) continue;
    CHECK(result.status == MeshStatus::Cancelled);
    REQUIRE(result.errors.size() == 1);
    CHECK(result.errors[0].code == ErrorCode::Cancelled);
  }
}

TEST_CASE("the callback hears of the stages in order and can cancel in each of them") {
  const auto model = make_cylinder(0.5, 1);
  std::vector<Stage> stages;
  Host host;
  host.progress = [&](const ProgressEvent& event) {
    if (stages.empty() || stages.back() != event.stage) stages.push_back(event.stage);
    return true;
  };
  REQUIRE(make_mesh(*model, options_of_size(0.2), host).status == MeshStatus::Ok);
  CHECK(std::is_sorted(stages.begin(), stages.end()));
  CHECK(std::count(stages.begin(), stages.end(), Stage::Faces) == 1);
  for (const Stage stop : stages) {
    host.progress = [&](const ProgressEvent& event) { return event.stage != stop; };
    CHECK(make_mesh(*model, options_of_size(0.2), host).status == MeshStatus::Cancelled);
  }
}
