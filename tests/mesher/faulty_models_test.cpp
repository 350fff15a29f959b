// Models with the faults of real CAD files, from reading to the mesh.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <memory>
#include <numbers>
#include <optional>
#include <set>
#include <utility>

#include "tests/cad/cad_samples.hpp"
#include "tests/cad/faulty_samples.hpp"
#include "tests/support/temporary_folder.hpp"
#include "tests/support/with_attributes.hpp"
#include "tetloom/check.hpp"
#include "tetloom/mesh.hpp"
#include "tetloom/model.hpp"

using namespace tetloom;
using test::Fault;

namespace {

struct Meshed {
  ModelDocument document;
  MeshResult result;
};

MeshOptions options_for(double size, double curvature) {
  MeshOptions options;
  options.sizes.size = size;
  options.sizes.curvature = curvature;
  options.threads = 1;
  options.keep_small_features = true;
  options.volume_worker = TETLOOM_WORKER;
  return options;
}

Meshed read_faulty(Fault fault) {
  const test::TemporaryFolder folder;
  test::write_faulty(fault, folder / "model.brep");
  return {read_model(folder / "model.brep"), {}};
}

/// The model with edges that are known to be no more exact than a tolerance.
std::unique_ptr<GeometricModel> inexact(std::unique_ptr<GeometricModel> model, double tolerance) {
  auto changed = std::make_unique<test_models::WithAttributes>(std::move(model));
  for (std::size_t e = 0; e < changed->topology().edge_count(); ++e) changed->change(1, e).tolerance = tolerance;
  return changed;
}

void mesh(Meshed& meshed, double size, double curvature = 0, bool keep_going = false) {
  MeshOptions options = options_for(size, curvature);
  options.keep_going = keep_going;
  meshed.result = make_mesh(*meshed.document.model, options);
}

Meshed mesh_faulty(Fault fault, double size, double curvature = 0, bool keep_going = false) {
  Meshed meshed = read_faulty(fault);
  mesh(meshed, size, curvature, keep_going);
  return meshed;
}

double volume_of(const Meshed& meshed) { return compute_quality(meshed.result.mesh, nullptr).tets.volume; }

double area_of(const Meshed& meshed) {
  const Mesh& mesh = meshed.result.mesh;
  double area = 0;
  for (const auto& [a, b, c] : mesh.tri_to_vert)
    area += 0.5 * norm(cross(mesh.points[b] - mesh.points[a], mesh.points[c] - mesh.points[a]));
  return area;
}

std::string first_error(const Meshed& meshed) {
  return meshed.result.errors.empty() ? "" : meshed.result.errors.front().message;
}

void require_valid(const Meshed& meshed) {
  INFO(first_error(meshed));
  REQUIRE(meshed.result.status == MeshStatus::Ok);
  const ValidationReport report = validate_mesh(meshed.result.mesh);
  INFO((report.problems.empty() ? std::string() : report.problems.front().message));
  CHECK(report.problems.empty());
}

}  // namespace

TEST_CASE("loops that touch at a vertex are meshed though their parameter curves end beside each other") {
  const Meshed meshed = mesh_faulty(Fault::TouchingLoops, 1);
  require_valid(meshed);
  CHECK(area_of(meshed) == Approx(100 - 4));
}

TEST_CASE("a line and an arc that coincide become one piece") {
  const Meshed meshed = mesh_faulty(Fault::TangentHole, 1, 24);
  require_valid(meshed);
  CHECK(area_of(meshed) == Approx(400 - std::numbers::pi * 9).epsilon(0.01));
}

TEST_CASE("the wall of no thickness between a hole and the side that it touches is left out") {
  const Meshed meshed = mesh_faulty(Fault::TangentHoleInPlate, 1, 24);
  require_valid(meshed);
  CHECK(volume_of(meshed) == Approx(5 * (400 - std::numbers::pi * 9)).epsilon(0.01));
}

TEST_CASE("two lines between the same vertices share their nodes") {
  const Meshed meshed = mesh_faulty(Fault::DoubledEdge, 1);
  require_valid(meshed);
  const Mesh& mesh = meshed.result.mesh;
  const auto on_line =
      std::count_if(mesh.points.begin(), mesh.points.end(), [](const Vec3& x) { return std::abs(x.x) < 1e-9; });
  CHECK(on_line == 11);
}

TEST_CASE("a face whose parametrisation folds over is meshed between its edges") {
  for (const double curvature : {0.0, 24.0}) {
    const Meshed meshed = mesh_faulty(Fault::FoldedCorner, 1, curvature);
    require_valid(meshed);
    CHECK(volume_of(meshed) == Approx(120).epsilon(0.001));
  }
}

TEST_CASE("a curve that misses its vertices is fitted to them") {
  const Meshed meshed = mesh_faulty(Fault::CurveShortOfVertex, 2);
  require_valid(meshed);
  CHECK(volume_of(meshed) == Approx(1000));
}

TEST_CASE("a solid that crosses itself is refused, and meshed when it is made anew") {
  const Fault fault = GENERATE(Fault::FloorInOuterFace, Fault::FloorWithoutThickness, Fault::FloorBeyondOuterFace);
  const std::size_t boxes = fault == Fault::FloorBeyondOuterFace ? 2 : 1;
  Meshed meshed = mesh_faulty(fault, 2);
  CHECK(meshed.result.status == MeshStatus::Failed);
  CHECK_FALSE(meshed.result.stopped_early);
  REQUIRE_FALSE(meshed.result.errors.empty());
  CHECK(meshed.result.errors.front().code == ErrorCode::SelfIntersection);
  const std::vector crossing = regions_that_cross(meshed.result, meshed.document.model->topology());
  CHECK(crossing == std::vector{ModelRegionId(0)});

  std::optional<ModelDocument> rebuilt = rebuild_solids(meshed.document, crossing);
  REQUIRE(rebuilt.has_value());
  CHECK(rebuilt->format == "BREP");
  CHECK(rebuilt->healing.back().count == 1);
  meshed.document = std::move(*rebuilt);
  mesh(meshed, 2, 24);
  require_valid(meshed);
  CHECK(meshed.document.model->topology().region_count() == boxes);
  CHECK(volume_of(meshed) == Approx(1000.0 * boxes - 40 * std::numbers::pi).epsilon(0.01));
}

TEST_CASE("a solid without thickness somewhere is refused at once, with the faces and a point") {
  const Meshed meshed = mesh_faulty(Fault::FloorWithoutThickness, 2);
  CHECK(meshed.result.refinement.rounds == 0);
  REQUIRE(meshed.result.errors.size() == 1);
  const Diagnostic& error = meshed.result.errors.front();
  CHECK(error.entities.size() == 2);
  REQUIRE(error.point.has_value());
  CHECK(std::hypot(error.point->x - 5, error.point->y - 5) < 2);
  CHECK(error.point->z == Approx(10));
}

TEST_CASE("a run may stop as soon as it is sure that faces cross in the model") {
  const auto stops = [](Fault fault) {
    Meshed meshed = read_faulty(fault);
    MeshOptions options = options_for(2, 24);
    options.stop_where_model_crosses = true;
    options.keep_going = true;
    meshed.result = make_mesh(*meshed.document.model, options);
    return std::move(meshed.result);
  };
  const MeshResult crossing = stops(Fault::FloorBeyondOuterFace);
  CHECK(crossing.stopped_early);
  CHECK(crossing.refinement.rounds == 0);
  CHECK(crossing.status == MeshStatus::Failed);
  REQUIRE(crossing.errors.size() == 1);
  CHECK(crossing.errors.front().code == ErrorCode::SelfIntersection);
  REQUIRE(crossing.errors.front().point.has_value());
  const Vec3 place = *crossing.errors.front().point;
  CHECK(std::hypot(place.x - 5, place.y - 5) == Approx(2));
  CHECK(place.z == Approx(10));
  CHECK_FALSE(stops(Fault::FloorInOuterFace).stopped_early);  // faces that touch are left to the triangles
  CHECK_FALSE(stops(Fault::CrossingShells).stopped_early);    // two solids, which may cross
}

TEST_CASE("models of facets and solids that nothing is left of are not made anew") {
  const Meshed meshed = read_faulty(Fault::FloorBeyondOuterFace);
  CHECK_FALSE(rebuild_solids(meshed.document, {}).has_value());
  CHECK_FALSE(rebuild_solids(meshed.document, {ModelRegionId(7)}).has_value());
}

TEST_CASE("closed shells that cross bound a solid each") {
  const Meshed meshed = mesh_faulty(Fault::CrossingShells, 2);
  require_valid(meshed);
  CHECK(meshed.document.model->topology().region_count() == 2);
  CHECK(volume_of(meshed) == Approx(1000 + std::numbers::pi * 64 * 4).epsilon(0.03));
}

TEST_CASE("a closed shell wholly inside another one is its cavity") {
  const Meshed meshed = mesh_faulty(Fault::NestedShells, 2);
  require_valid(meshed);
  CHECK(meshed.document.model->topology().region_count() == 1);
  CHECK(volume_of(meshed) == Approx(1000 - 64));
}

TEST_CASE("loose faces without area are left out, and said to be") {
  const Meshed meshed = mesh_faulty(Fault::CollapsedFaces, 2);
  require_valid(meshed);
  CHECK(meshed.document.model->topology().face_count() == 6);
  CHECK(volume_of(meshed) == Approx(1000));
  const auto& steps = meshed.document.healing;
  CHECK(std::any_of(steps.begin(), steps.end(), [](const HealingStep& step) {
    return step.what.find("without area") != std::string::npos && step.count == 3;
  }));
}

TEST_CASE("a solid of two faces on each other is left out beside others, and said to be") {
  const Meshed meshed = mesh_faulty(Fault::FlatSolidAndBox, 2);
  require_valid(meshed);
  CHECK(volume_of(meshed) == Approx(1000));
  const auto& warnings = meshed.result.warnings;
  const auto told = std::ranges::find_if(
      warnings, [](const Diagnostic& warning) { return warning.message.find("has no volume") != std::string::npos; });
  REQUIRE(told != warnings.end());
  REQUIRE(told->entities.size() == 3);
  CHECK(told->entities.front().entity == ModelEntity(ModelRegionId(0)));
}

TEST_CASE("a solid of two faces on each other alone is refused by name") {
  const Meshed meshed = mesh_faulty(Fault::FlatSolid, 2);
  CHECK(meshed.result.status == MeshStatus::Failed);
  REQUIRE(meshed.result.errors.size() == 1);
  CHECK(meshed.result.errors.front().message.find("encloses no volume") != std::string::npos);
  CHECK(meshed.result.errors.front().point);
  REQUIRE(meshed.result.errors.front().entities.size() == 3);
  CHECK(meshed.result.errors.front().entities.front().entity == ModelEntity(ModelRegionId(0)));
}

TEST_CASE("the halves of a sphere have one surface and one rim, and do not lie on each other") {
  const test::TemporaryFolder folder;
  write_sample(test::Sample::HalvedSphere, folder / "model.step");
  for (const double size : {1.0, 3.0, 6.0}) {
    INFO("size " << size);
    Meshed meshed{read_model(folder / "model.step"), {}};
    REQUIRE(meshed.document.model->topology().face_count() == 2);
    mesh(meshed, size);
    CHECK(meshed.result.status == MeshStatus::Ok);
    for (const Diagnostic& error : meshed.result.errors) FAIL_CHECK(error.message);
    if (size < 2) CHECK(volume_of(meshed) == Approx(4 * M_PI / 3 * 125).epsilon(0.03));
  }
}

TEST_CASE("beside a solid that is refused the others are meshed where the host wants to keep going") {
  const Meshed meshed = mesh_faulty(Fault::FloorBeyondOuterFace, 2, 0, true);
  CHECK(meshed.result.status == MeshStatus::Failed);
  CHECK(meshed.result.is_partial);
  REQUIRE_FALSE(meshed.result.errors.empty());
  CHECK(meshed.result.errors.front().code == ErrorCode::SelfIntersection);
  CHECK(validate_mesh(meshed.result.mesh).problems.empty());
  CHECK(volume_of(meshed) == Approx(1000));
  CHECK(meshed.result.model_volume == Approx(1000));
}

TEST_CASE("a rod far thinner than the size keeps its volume where curvature is asked for") {
  const Meshed meshed = mesh_faulty(Fault::ThinRod, 1, 12);
  require_valid(meshed);
  CHECK(volume_of(meshed) == Approx(std::numbers::pi * 0.01 * 10).epsilon(0.04));
}

TEST_CASE("solids that interpenetrate are meshed on their own, and named") {
  const Meshed meshed = mesh_faulty(Fault::OverlappingBoxes, 2);
  require_valid(meshed);
  CHECK(volume_of(meshed) == Approx(2000));
  const auto& warnings = meshed.result.warnings;
  const auto overlap = std::find_if(warnings.begin(), warnings.end(), [](const Diagnostic& warning) {
    return warning.code == ErrorCode::RegionsOverlap;
  });
  REQUIRE(overlap != warnings.end());
  REQUIRE(overlap->entities.size() >= 2);
  CHECK(overlap->entities[0].entity.dim == 3);
  CHECK(overlap->entities[1].entity.dim == 3);
  CHECK(overlap->entities[0].entity != overlap->entities[1].entity);
}

TEST_CASE("solids that only touch do not overlap") {
  const test::TemporaryFolder folder;
  test::write_sample(test::Sample::TouchingBoxes, folder / "model.brep");
  const ModelDocument document = read_model(folder / "model.brep");
  MeshOptions options;
  options.sizes.size = 2;
  options.volume_worker = TETLOOM_WORKER;
  const MeshResult result = make_mesh(*document.model, options);
  REQUIRE(result.status == MeshStatus::Ok);
  REQUIRE(document.model->topology().region_count() == 2);
  for (const Diagnostic& warning : result.warnings) CHECK(warning.code != ErrorCode::RegionsOverlap);
}

TEST_CASE("a face no wider than its edges are exact is left out") {
  Meshed meshed = read_faulty(Fault::NarrowStep);
  const double volume = meshed.document.model->volume(ModelRegionId(0));
  SECTION("exact") {
    mesh(meshed, 8);
    require_valid(meshed);
    const auto& faces = meshed.result.mesh.tri_to_entity;
    CHECK(std::set(faces.begin(), faces.end()).size() == meshed.document.model->topology().face_count());
  }
  SECTION("its arc is known to 1.2, and 1 from its chord") {
    meshed.document.model = inexact(std::move(meshed.document.model), 1.2);
    mesh(meshed, 8);
    require_valid(meshed);
    const auto& faces = meshed.result.mesh.tri_to_entity;
    CHECK(std::set(faces.begin(), faces.end()).size() + 1 == meshed.document.model->topology().face_count());
    CHECK(volume_of(meshed) == Approx(volume).epsilon(0.1));
  }
}
