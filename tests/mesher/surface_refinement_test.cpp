#include <catch2/catch.hpp>
#include <numbers>

#include "tests/mesher/options_of_size.hpp"
#include "tests/support/analytic_model.hpp"
#include "tetloom/check.hpp"
#include "tetloom/mesh.hpp"

using namespace tetloom;
using namespace tetloom::test_models;

namespace {

/// With its quality; checks that it is whole.
struct Made {
  MeshResult result;
  QualityReport quality;

  Made(const GeometricModel& model, const MeshOptions& options) : result(make_mesh(model, options)) {
    REQUIRE(result.status == MeshStatus::Ok);
    CHECK(validate_mesh(result.mesh).problems.empty());
    quality = compute_quality(result.mesh, &result.sizes);
    CHECK(quality.tets.volume == Approx(result.model_volume).epsilon(0.03));
    CHECK(result.filling.worker_complexes == 0);
  }
};

const Diagnostic* find_warning(const MeshResult& result) {
  for (const Diagnostic& warning : result.warnings)
    if (warning.code == ErrorCode::SizeReduced) return &warning;
  return nullptr;
}

/// Over a triangle with this angle, in degrees, at the edge from (0, 0) to (0, width).
std::unique_ptr<GeometricModel> make_wedge(double degrees, double length, double width) {
  const double height = length * std::tan(degrees * std::numbers::pi / 180);
  const std::vector<Vec3> points{{0, 0, 0},     {length, 0, 0},     {length, 0, height},
                                 {0, width, 0}, {length, width, 0}, {length, width, height}};
  const std::vector<std::vector<std::uint32_t>> faces{{0, 1, 2}, {3, 5, 4}, {0, 3, 4, 1}, {0, 2, 5, 3}, {1, 4, 5, 2}};
  return make_polyhedron(points, faces);
}

}  // namespace

TEST_CASE("plates however thin get tets of 15 degrees and more") {
  for (const double thickness : {0.03, 0.05, 0.1, 0.15, 0.2, 0.25, 0.3, 0.35, 0.4}) {
    INFO("thickness " << thickness);
    const auto model = make_box({0, 0, 0}, {6, 5, thickness});
    MeshOptions options = options_of_size(1);
    options.sizes.min_size = 0.01;
    options.most_refinement = HUGE_VAL;
    const Made fitting(*model, options);
    CHECK(fitting.quality.tets.min_dihedral_deg >= 15);
    options.refine_surface = false;
    const Made kept(*model, options);
    CHECK(kept.result.sizes.is_uniform());
    CHECK(find_warning(kept.result) == nullptr);
    CHECK(kept.result.refinement.rounds == 0);
    if (thickness > 0.25) continue;
    CHECK(kept.quality.tets.min_dihedral_deg < 15);
    CHECK(fitting.result.refinement.smallest_size == Approx(2.5 * thickness).epsilon(0.05));
    const Diagnostic* const warning = find_warning(fitting.result);
    REQUIRE(warning != nullptr);
    CHECK(warning->point.has_value());
    CHECK_FALSE(warning->entities.empty());
  }
}

TEST_CASE("sizes are reduced to min_size, to what features that stay need, or to a tenth, and no further") {
  const auto model = make_box({0, 0, 0}, {2, 2, 0.03}), thicker = make_box({0, 0, 0}, {2, 2, 0.1});
  MeshOptions options = options_of_size(1);
  options.most_refinement = HUGE_VAL;
  CHECK(Made(*thicker, options).result.refinement.smallest_size == Approx(0.25));
  // Where the angle would be below 5 degrees, to what makes it 9.
  CHECK(Made(*model, options).result.refinement.smallest_size == Approx(0.15).epsilon(0.01));
  options.keep_small_features = true;
  CHECK(Made(*model, options).result.refinement.smallest_size == Approx(0.1));
  options.sizes.min_size = 0.14;
  CHECK(Made(*model, options).result.refinement.smallest_size == Approx(0.14));
}

TEST_CASE("a thin disc is refined as a plate is, where its size follows its rim") {
  std::vector<std::shared_ptr<const GeometricModel>> bodies{make_box({2, 0, 0}, {4, 2, 2}), make_cylinder(0.2, 0.003)};
  MeshOptions options = options_of_size(0.3);
  options.sizes.curvature = 24;
  const Made made(*combine(bodies), options);
  CHECK(made.quality.tets.min_dihedral_deg > 8);
  CHECK(made.result.refinement.smallest_size == Approx(0.015).epsilon(0.01));
}

TEST_CASE("wires and balls keep their shape where a size alone is asked for") {
  std::vector<std::shared_ptr<const GeometricModel>> bodies{make_box({0, 0, 0}, {4, 4, 4}),
                                                            make_sphere({8, 0, 0}, 0.4)};
  const std::unique_ptr<GeometricModel> models[] = {make_cylinder(0.2, 20), make_torus(3, 0.15), combine(bodies)};
  for (const auto& model : models) {
    const auto lost_of = [&](const MeshOptions& options) {
      const MeshResult result = make_mesh(*model, options);
      if (result.status != MeshStatus::Ok) return 1.0;  // a tube of so few triangles crosses itself
      CHECK(validate_mesh(result.mesh).problems.empty());
      // Of the last region, which is thin.
      const auto region = static_cast<std::uint32_t>(model->topology().region_count() - 1);
      double volume = 0;
      for (std::size_t t = 0; t < result.mesh.tet_to_vert.size(); ++t) {
        if (result.mesh.tet_to_entity[t] != region) continue;
        const auto& [a, b, c, d] = result.mesh.tet_to_vert[t];
        const auto& x = result.mesh.points;
        volume += dot(cross(x[b] - x[a], x[c] - x[a]), x[d] - x[a]) / 6;
      }
      return 1 - volume / model->volume(ModelRegionId(region));
    };
    MeshOptions options = options_of_size(1);
    CHECK(lost_of(options) < 0.12);
    options.most_refinement = HUGE_VAL;
    CHECK(lost_of(options) < 0.08);
    options.refine_surface = false;
    CHECK(lost_of(options) > 0.2);
    options.refine_surface = true, options.most_refinement = 1;
    CHECK(lost_of(options) > 0.2);
    options.most_refinement = 2, options.sizes.min_size = 1;
    CHECK(lost_of(options) > 0.2);
  }
  // What is no wire has the size asked for.
  CHECK(make_mesh(*make_cylinder(3, 2), options_of_size(1)).sizes.is_uniform());
  CHECK(make_mesh(*make_annulus(0.3, 4), options_of_size(1)).sizes.is_uniform());
}

TEST_CASE("needles and narrow faces have finer elements beside them") {
  MeshOptions options = options_of_size(0.5);
  options.most_refinement = HUGE_VAL;
  const Made needle(*make_box({0, 0, 0}, {8, 0.1, 0.1}), options);
  CHECK(needle.quality.tets.min_dihedral_deg >= 15);
  CHECK(needle.result.refinement.narrow_places > 0);
  const Made chamfered(*make_chamfered_cube(0.06), options);
  CHECK(chamfered.quality.tets.min_dihedral_deg >= 15);
  CHECK(chamfered.result.refinement.narrow_places > 0);
  options.refine_surface = false;
  CHECK(Made(*make_chamfered_cube(0.06), options).quality.tets.min_dihedral_deg < 15);
}

TEST_CASE("what a smaller size would not make better stays as it is") {
  const auto expect_no_refinement = [](const GeometricModel& model, double size) {
    const Made made(model, options_of_size(size));
    CHECK(made.result.refinement.rounds == 0);
    CHECK(find_warning(made.result) == nullptr);
  };
  for (const double degrees : {5.0, 10.0, 15.0}) expect_no_refinement(*make_wedge(degrees, 4, 3), 0.3);
  // Far too thin for the smallest size allowed.
  expect_no_refinement(*make_box({0, 0, 0}, {2, 2, 0.0004}), 1);
  // Solids that touch are no walls to each other.
  const std::vector<std::shared_ptr<const GeometricModel>> bodies{
      make_box({0, 0, 0}, {1, 1, 1}), make_box({1, 0, 0}, {2, 1, 1}), make_box({0, 0, 1.001}, {1, 1, 2})};
  expect_no_refinement(*combine(bodies), 0.2);
  expect_no_refinement(*make_sphere({0, 0, 0}, 1), 0.2);
}

TEST_CASE("a size may jump by ten thousand") {
  MeshOptions options = options_of_size(0.2);
  options.sizes.gradation = 1;
  for (const Vec3& place : {Vec3{0.4, 0.5, 0.6}, Vec3{0, 0, 0}, Vec3{0.31, 0, 0.22}}) {
    options.sizes.point_sizes = {{place, 2e-5}};
    const Made made(*make_box({0, 0, 0}, {1, 1, 1}), options);
    CHECK(made.result.sizes.size_at(place) < 4e-5);
    CHECK(made.quality.tets.min_dihedral_deg >= 5);
    CHECK(made.quality.tets.mean_ratio_mean > 0.7);
  }
}

TEST_CASE("sizes that fit but not in memory are not used") {
  const auto model = make_box({0, 0, 0}, {40, 30, 0.1});
  MeshOptions options = options_of_size(1);
  options.max_memory = std::uint64_t{12} << 20;
  options.most_refinement = HUGE_VAL;
  const Made made(*model, options);
  const Diagnostic* const warning = find_warning(made.result);
  REQUIRE(warning != nullptr);
  CHECK_THAT(warning->message, Catch::Contains("memory"));
  CHECK(made.result.sizes.smallest() == Approx(1));
}

TEST_CASE("refined surfaces are the same on any number of threads") {
  const auto model = make_box({0, 0, 0}, {6, 5, 0.1});
  MeshOptions options = options_of_size(1);
  options.threads = 1;
  const std::string reference = mesh_digest(make_mesh(*model, options).mesh);
  for (const int threads : {2, 5}) {
    options.threads = threads;
    CHECK(mesh_digest(make_mesh(*model, options).mesh) == reference);
  }
}
