// Small features eliminated from the surface meshes of whole models.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <map>
#include <numbers>
#include <random>

#include "mesher/features/small_features.hpp"
#include "mesher/sizing/refinement_budget.hpp"
#include "tests/mesher/options_of_size.hpp"
#include "tests/support/analytic_model.hpp"
#include "tests/support/analytic_shapes.hpp"
#include "tetloom/check.hpp"
#include "tetloom/mesh.hpp"
#include "tetloom/tasks.hpp"

using namespace tetloom;
using namespace tetloom::test_models;

namespace {

/// Two blocks side by side of which one is higher by `step`: an L of six faces around and two at the ends, whose edges
/// along z are cut where the outline bends.
std::unique_ptr<GeometricModel> make_stepped_block(double step) {
  const std::vector<Vec3> points{{0, 0, 0}, {2, 0, 0}, {2, 0, 1}, {1, 0, 1}, {1, 0, 1 + step}, {0, 0, 1 + step},
                                 {0, 1, 0}, {2, 1, 0}, {2, 1, 1}, {1, 1, 1}, {1, 1, 1 + step}, {0, 1, 1 + step}};
  // The ends are not convex: each is two rings, so that every ring is.
  const std::vector<std::vector<std::uint32_t>> faces{{0, 1, 2, 3},   {0, 3, 4, 5}, {9, 8, 7, 6}, {11, 10, 9, 6},
                                                      {0, 6, 7, 1},   {1, 7, 8, 2}, {2, 8, 9, 3}, {3, 9, 10, 4},
                                                      {4, 10, 11, 5}, {5, 11, 6, 0}};
  return make_polyhedron(points, faces);
}

/// A wedge along y, 1 long in x, with a blunt tip of this width.
std::unique_ptr<GeometricModel> make_blunt_wedge(double degrees, double width) {
  const double tip = 0.5 * width, base = tip + std::tan(0.5 * degrees * kDegree);
  const std::vector<Vec3> points{{0, 0, -base}, {1, 0, -tip}, {1, 0, tip}, {0, 0, base},
                                 {0, 1, -base}, {1, 1, -tip}, {1, 1, tip}, {0, 1, base}};
  const std::vector<std::vector<std::uint32_t>> faces{{0, 1, 2, 3}, {7, 6, 5, 4}, {0, 4, 5, 1},
                                                      {1, 5, 6, 2}, {2, 6, 7, 3}, {3, 7, 4, 0}};
  return make_polyhedron(points, faces);
}

/// A block with a slot along y from the top to half its height, whose floor has this width and whose walls diverge by
/// this angle.
std::unique_ptr<GeometricModel> make_slotted_block(double width, double degrees) {
  const double floor = 0.5 * width, top = floor + 0.5 * std::tan(0.5 * degrees * kDegree);
  std::vector<Vec3> points{{0, 0, 0},           {2, 0, 0},           {2, 0, 1},       {1 + top, 0, 1},
                           {1 + floor, 0, 0.5}, {1 - floor, 0, 0.5}, {1 - top, 0, 1}, {0, 0, 1}};
  // The ends are not convex: each is three rings.
  std::vector<std::vector<std::uint32_t>> faces{{0, 5, 6, 7}, {0, 1, 4, 5}, {1, 2, 3, 4}};
  for (std::size_t i = 0; i < 3; ++i) {
    std::vector<std::uint32_t> ring(faces[i].rbegin(), faces[i].rend());
    for (std::uint32_t& v : ring) v += 8;
    faces.push_back(std::move(ring));
  }
  for (std::uint32_t i = 0; i < 8; ++i) {
    const std::uint32_t j = (i + 1) % 8;
    points.push_back(points[i] + Vec3{0, 1, 0});
    faces.push_back({i, i + 8, j + 8, j});
  }
  return make_polyhedron(points, faces);
}

struct Made {
  MeshResult result;
  QualityReport quality;
  Made(const GeometricModel& model, const MeshOptions& options) : result(make_mesh(model, options)) {
    REQUIRE(result.status == MeshStatus::Ok);
    for (const MeshProblem& problem : validate_mesh(result.mesh).problems) FAIL_CHECK(problem.message);
    quality = compute_quality(result.mesh, &result.sizes);
  }
  bool absorbed(ModelEntity entity) const {
    return std::ranges::any_of(result.absorbed, [&](const AbsorbedEntity& one) { return one.entity == entity; });
  }
};

}  // namespace

TEST_CASE("a chamfer far below the size becomes an edge") {
  for (const double width : {1e-6, 1e-4, 0.002, 0.01}) {
    INFO("width " << width);
    const auto model = make_chamfered_cube(width);
    const Made made(*model, options_of_size(0.2));
    CHECK(made.quality.tets.min_dihedral_deg >= 15);
    CHECK(made.result.refinement.rounds == 0);
    CHECK(made.quality.tets.volume == Approx(made.result.model_volume).epsilon(0.01));
    CHECK(made.absorbed(ModelFaceId(4)));
    for (const AbsorbedEntity& absorbed : made.result.absorbed) {
      CHECK(absorbed.distance <= 0.1 * 0.2);
      CHECK(absorbed.into.valid());
    }
    CHECK(std::ranges::is_sorted(made.result.absorbed, {}, &AbsorbedEntity::entity));
  }
}

TEST_CASE("the blunt tip of a wedge goes where the sharp wedge has the larger angle") {
  for (const double width : {1e-5, 1e-3, 4e-3}) {
    INFO("width " << width);
    MeshOptions options = options_of_size(0.1);
    options.refine_surface = false;
    const Made made(*make_blunt_wedge(12, width), options);
    CHECK(made.absorbed(ModelFaceId(3)));
    CHECK(made.quality.tets.min_dihedral_deg >= 9);
    CHECK(made.quality.tets.volume == Approx(made.result.model_volume).epsilon(0.01));
  }
}

TEST_CASE("the floor of a slot goes where the walls hardly diverge: nothing is meshed between them") {
  for (const double degrees : {0.5, 1.0, 10.0}) {
    INFO("degrees " << degrees);
    MeshOptions options = options_of_size(0.1);
    options.refine_surface = false;
    const Made made(*make_slotted_block(0.004, degrees), options);
    CHECK(made.absorbed(ModelFaceId(10)));
    CHECK(made.quality.tets.min_dihedral_deg >= 12);
    CHECK(made.quality.tets.volume == Approx(made.result.model_volume).epsilon(0.005));
  }
}

TEST_CASE("the floor of a slit with parallel walls goes, however narrow it is") {
  for (const double width : {1e-6, 1e-4, 0.004}) {
    INFO("width " << width);
    const Made made(*make_slotted_block(width, 0), options_of_size(0.1));
    CHECK(made.absorbed(ModelFaceId(10)));
    CHECK(made.quality.tets.min_dihedral_deg >= 12);
    CHECK(made.quality.tets.volume == Approx(made.result.model_volume).epsilon(0.005));
  }
}

TEST_CASE("what is small beside the size but not beside the solid stays") {
  // The chamfer is a hundredth of the volume, and below a tenth of the size.
  MeshOptions options = options_of_size(2.2);
  options.refine_surface = false;
  const auto model = make_chamfered_cube(0.2);
  const Made made(*model, options);
  CHECK_FALSE(made.absorbed(ModelFaceId(4)));
  CHECK(made.quality.tets.volume == Approx(made.result.model_volume).epsilon(0.005));
  options.sizes.size = 0.3;
  CHECK(Made(*make_chamfered_cube(0.02), options).absorbed(ModelFaceId(4)));
}

TEST_CASE("a region that lost too much of its volume has less eliminated from it") {
  const auto model = make_chamfered_cube(0.015);
  MeshOptions options = options_of_size(0.2);
  options.keep_small_features = options.surface_only = true;
  const Made given(*model, options);
  options.small_feature = 0.02;
  SmallFeatures features(*model, options, SizeField::uniform(0.2));
  const TaskRunner runner(1);
  const SizeField sizes = SizeField::uniform(0.2);
  CHECK(features.eliminate(given.result.mesh, sizes, runner).mesh.has_value());
  EliminationResult lower{.mesh = given.result.mesh, .absorbed = {}, .changed = {}};
  CHECK_FALSE(features.spare_regions(given.result.mesh, lower));
  for (Vec3& x : lower.mesh->points) x.z *= 0.98;
  CHECK(features.spare_regions(given.result.mesh, lower));
  CHECK_FALSE(features.eliminate(given.result.mesh, sizes, runner).mesh.has_value());
}

TEST_CASE("a step far below the size goes, one that is not stays") {
  const Made low(*make_stepped_block(0.005), options_of_size(0.25));
  CHECK(low.absorbed(ModelFaceId(7)));
  CHECK(low.quality.tets.min_dihedral_deg >= 10);
  const Made high(*make_stepped_block(0.1), options_of_size(0.25));
  CHECK(high.result.absorbed.empty());
}

TEST_CASE("small features stay where they are asked to, or are larger than asked") {
  const auto model = make_chamfered_cube(0.01);
  MeshOptions options = options_of_size(0.2);
  options.refine_surface = false;
  options.keep_small_features = true;
  CHECK(Made(*model, options).result.absorbed.empty());
  options.keep_small_features = false;
  options.small_feature = 0.005;
  CHECK(Made(*model, options).result.absorbed.empty());
  options.small_feature = 0.011;
  CHECK(Made(*model, options).absorbed(ModelFaceId(4)));
}

TEST_CASE("thin plates and needles keep their sides") {
  for (const double thickness : {1e-3, 0.01, 0.05}) {
    INFO("thickness " << thickness);
    MeshOptions options = options_of_size(1);
    options.refine_surface = false;
    const Made plate(*make_box({0, 0, 0}, {4, 3, thickness}), options);
    CHECK(plate.result.absorbed.empty());
    CHECK(plate.quality.tets.volume == Approx(12 * thickness));
  }
}

TEST_CASE("options of small features are checked") {
  MeshOptions options = options_of_size(0.5);
  for (const double wrong : {-1.0, std::numeric_limits<double>::quiet_NaN(), HUGE_VAL}) {
    options.small_feature = wrong;
    CHECK_THROWS_AS(make_mesh(*make_box({0, 0, 0}, {1, 1, 1}), options), Error);
  }
  options.small_feature = 0;
  for (const double wrong : {0.5, -1.0, std::numeric_limits<double>::quiet_NaN()}) {
    options.most_refinement = wrong;
    CHECK_THROWS_AS(make_mesh(*make_box({0, 0, 0}, {1, 1, 1}), options), Error);
  }
}

TEST_CASE("meshes without small features are the same on any number of threads") {
  const auto model = make_chamfered_cube(0.004);
  MeshOptions options = options_of_size(0.1);
  options.threads = 1;
  const std::string reference = mesh_digest(make_mesh(*model, options).mesh);
  for (const int threads : {2, 5}) {
    options.threads = threads;
    CHECK(mesh_digest(make_mesh(*model, options).mesh) == reference);
  }
}

TEST_CASE("refinement at narrow places keeps to its budget") {
  const auto model = make_box({0, 0, 0}, {48, 40, 0.08});
  const auto tets = [&](double factor) {
    MeshOptions options = options_of_size(1);
    options.most_refinement = factor;
    options.sizes.min_size = 0.01;
    const Made made(*model, options);
    CHECK((made.result.refinement.left > 0) == (factor < 100));
    return static_cast<double>(made.result.mesh.tet_to_vert.size());
  };
  MeshOptions asked = options_of_size(1);
  asked.refine_surface = false;
  const auto least = static_cast<double>(Made(*model, asked).result.mesh.tet_to_vert.size());
  const double twice = tets(2), four_times = tets(4), all = tets(HUGE_VAL);
  CHECK(twice > 1.2 * least);
  CHECK(twice < 2.6 * least);
  CHECK(four_times > 1.5 * twice);
  CHECK(four_times < 5 * least);
  CHECK(all > 4 * four_times);
  // So few elements are no burden, whatever the factor.
  const Made few(*make_box({0, 0, 0}, {12, 10, 0.08}), options_of_size(1));
  CHECK(few.result.mesh.tet_to_vert.size() > 10'000);
  CHECK(few.result.mesh.tet_to_vert.size() < 24'000);
}

TEST_CASE("a budget raises the narrowest places first, all to the same share of the size") {
  Mesh mesh;
  mesh.points = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  mesh.tri_to_vert = {{0, 1, 2}, {0, 1, 2}, {0, 1, 2}};
  const SizeField sizes = SizeField::uniform(1);
  const std::vector<Misfit> misfits{{0, 0.8}, {1, 0.1}, {2, 0.05}};
  const AffordableMisfits all = choose_affordable(misfits, mesh, sizes, HUGE_VAL);
  REQUIRE(all.refined.size() == 3);
  CHECK(all.left == 0);
  CHECK(all.refined[1].size == Approx(0.1));
  const AffordableMisfits some = choose_affordable(misfits, mesh, sizes, 100);
  REQUIRE(some.refined.size() == 2);
  CHECK(some.left == 3);
  CHECK(some.refined[0].triangle == 1);
  CHECK(some.refined[0].size == Approx(2 * some.refined[1].size));
  CHECK(some.cost <= 100);
  CHECK(some.cost > 99);
  CHECK(choose_affordable(misfits, mesh, sizes, 0).refined.empty());
}
