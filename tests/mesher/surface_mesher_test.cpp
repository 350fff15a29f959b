#include "mesher/surface/surface_mesher.hpp"
#include "tetloom/tasks.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <map>
#include <numbers>

#include "mesher/intersection/new_triangles.hpp"
#include "mesher/sizing/build_size_field.hpp"
#include "tests/support/analytic_model.hpp"
#include "tetloom/check.hpp"

using namespace tetloom;
using namespace tetloom::test_models;

namespace {

struct SurfaceFigures {
  double area = 0, mean_quality = 0, smallest_angle = 180, mean_edge = 0, in_band = 0;
  bool closed = true;
};

using EdgeUses = std::map<std::pair<std::uint32_t, std::uint32_t>, int>;

EdgeUses count_edge_uses(const Mesh& mesh) {
  EdgeUses uses;
  for (const auto& tri : mesh.tri_to_vert)
    for (std::size_t i = 0; i < 3; ++i) ++uses[std::minmax(tri[i], tri[(i + 1) % 3])];
  return uses;
}

SurfaceFigures measure(const Mesh& mesh, double size) {
  SurfaceFigures figures;
  for (const auto& tri : mesh.tri_to_vert) {
    double squares = 0;
    const Vec3 a = mesh.points[tri[0]], b = mesh.points[tri[1]], c = mesh.points[tri[2]];
    const double area = 0.5 * norm(cross(b - a, c - a));
    for (std::size_t i = 0; i < 3; ++i) {
      const Vec3 p = mesh.points[tri[i]], u = mesh.points[tri[(i + 1) % 3]] - p, v = mesh.points[tri[(i + 2) % 3]] - p;
      squares += norm2(u);
      figures.smallest_angle =
          std::min(figures.smallest_angle, std::atan2(norm(cross(u, v)), dot(u, v)) * 180 / std::numbers::pi);
    }
    figures.area += area;
    figures.mean_quality += 4 * std::sqrt(3.0) * area / squares / static_cast<double>(mesh.tri_to_vert.size());
  }
  const EdgeUses uses = count_edge_uses(mesh);
  for (const auto& [edge, count] : uses) {
    const double length = distance(mesh.points[edge.first], mesh.points[edge.second]) / size;
    figures.mean_edge += length / static_cast<double>(uses.size());
    if (length >= std::sqrt(0.5) && length <= std::sqrt(2.0)) figures.in_band += 1.0 / static_cast<double>(uses.size());
    if (count != 2) figures.closed = false;
  }
  return figures;
}

SurfaceMeshResult mesh_uniformly(const GeometricModel& model, double size, int threads = 1) {
  return mesh_surface(model, SizeField::uniform(size), TaskRunner(threads));
}

void check_quality(const GeometricModel& model, double size, double area) {
  const SurfaceMeshResult result = mesh_uniformly(model, size);
  CHECK(result.errors.empty());
  CHECK(result.warnings.empty());
  const SurfaceFigures figures = measure(result.mesh, size);
  CHECK(figures.area == Approx(area).epsilon(0.01));
  CHECK(figures.mean_quality > 0.97);
  CHECK(figures.mean_edge == Approx(1).epsilon(0.03));
  CHECK(figures.in_band > 0.95);
  CHECK(figures.smallest_angle > 20);
}

}  // namespace

TEST_CASE("planar faces are meshed with nearly equilateral triangles of the size asked") {
  check_quality(*make_box({0, 0, 0}, {1, 1.3, 0.7}), 0.05, 2 * (1.3 + 0.7 + 0.91));
  check_quality(*make_plate(2, 1), 0.03, 2);
  check_quality(*make_annulus(0.3, 1), 0.04, std::numbers::pi * (1 - 0.09));
}

TEST_CASE("faces with seams and poles are meshed with nearly equilateral triangles of the size asked") {
  check_quality(*make_cylinder(0.5, 1), 0.05, std::numbers::pi * 1.5);
  check_quality(*make_sphere({1, 2, 3}, 0.7), 0.05, 4 * std::numbers::pi * 0.49);
  check_quality(*make_torus(1, 0.4), 0.06, 4 * std::numbers::pi * std::numbers::pi * 0.4);
}

TEST_CASE("the surface of a solid is closed: every edge belongs to two triangles") {
  for (const double size : {0.6, 0.3, 0.11, 0.05}) {
    INFO("size " << size);
    CHECK(measure(mesh_uniformly(*make_box({0, 0, 0}, {1, 1, 1}), size).mesh, size).closed);
    CHECK(measure(mesh_uniformly(*make_cylinder(0.5, 1), size).mesh, size).closed);
    CHECK(measure(mesh_uniformly(*make_cone(0.5, 1), size).mesh, size).closed);
    CHECK(measure(mesh_uniformly(*make_sphere({}, 0.5), size).mesh, size).closed);
    CHECK(measure(mesh_uniformly(*make_torus(1, 0.4), size).mesh, size).closed);
  }
}

TEST_CASE("points lie on the surface that they are classified on") {
  const auto model = make_sphere({0, 0, 0}, 2);
  const Mesh mesh = mesh_uniformly(*model, 0.2).mesh;
  REQUIRE(mesh.points.size() == mesh.point_to_entity.size());
  for (const Vec3& point : mesh.points) CHECK(norm(point) == Approx(2).epsilon(1e-12));
}

TEST_CASE("the same surface mesh on any number of threads") {
  std::vector<std::shared_ptr<const GeometricModel>> bodies;
  bodies.push_back(make_torus(1, 0.4));
  bodies.push_back(make_box({2, 0, 0}, {3, 1, 1}));
  bodies.push_back(make_cone(0.5, 2));
  const auto model = combine(bodies);
  const Mesh reference = mesh_uniformly(*model, 0.1).mesh;
  for (const int threads : {2, 3, 8}) {
    const Mesh mesh = mesh_uniformly(*model, 0.1, threads).mesh;
    CHECK(mesh.points == reference.points);
    CHECK(mesh.tri_to_vert == reference.tri_to_vert);
    CHECK(mesh.point_to_entity == reference.point_to_entity);
  }
}

TEST_CASE("edges that cross because they are too coarse are made finer") {
  // Between two circles that nearly touch there is room for less than the sagitta of a coarse chord.
  const auto model = make_annulus(0.97, 1);
  const SurfaceMeshResult result = mesh_uniformly(*model, 0.9);
  CHECK(result.errors.empty());
  CHECK(measure(result.mesh, 0.9).area == Approx(std::numbers::pi * (1 - 0.97 * 0.97)).epsilon(0.2));
}

TEST_CASE("a surface mesh can be cancelled from its progress callback") {
  const auto model = make_torus(1, 0.4);
  Host host;
  host.progress = [](const ProgressEvent& event) { return event.stage != Stage::Faces; };
  try {
    mesh_surface(*model, SizeField::uniform(0.01), TaskRunner(2, host));
    FAIL("not cancelled");
  } catch (const Error& error) {
    CHECK(error.code() == ErrorCode::Cancelled);
  }
}

TEST_CASE("a surface with smaller sizes somewhere is the one made from nothing, and only faces there are meshed") {
  // Also where the corners of the octree are not exact numbers.
  const Vec3 lo = GENERATE(Vec3{0, 0, 0}, Vec3{1. / 3, 100.1, -0.7});
  const auto model = make_box(lo, lo + Vec3{8, 8, 8});
  SizeOptions options;
  options.size = 0.5;
  options.point_sizes = {{lo, 0.2}};
  const TaskRunner runner(2);
  const auto at = [&](const Vec3& x) { return std::array<Vec3, 3>{lo + x, lo + x, lo + x}; };
  SizeFieldBuilder sizing(*model, options, runner);
  std::vector<SizeRefinement> refinements;
  SurfaceMesher mesher(*model, runner);
  mesher.mesh(sizing.build(refinements).sizes);
  CHECK(mesher.remeshed() == 6);
  refinements.push_back({at({4, 4, 8}), 0.2});
  const SizeField finer = sizing.build(refinements).sizes;
  const Mesh again = mesher.mesh(finer).mesh;
  CHECK(mesher.remeshed() == 1);
  CHECK(mesh_digest(again) == mesh_digest(mesh_surface(*model, finer, runner).mesh));
  mesher.mesh(finer);
  CHECK(mesher.remeshed() == 0);
  refinements.push_back({at({8, 8, 4}), 0.1});
  const SizeField finest = sizing.build(refinements).sizes;
  CHECK(mesh_digest(mesher.mesh(finest).mesh) == mesh_digest(mesh_surface(*model, finest, runner).mesh));
  CHECK(mesher.remeshed() >= 2);
  CHECK(mesher.remeshed() < 6);
}

TEST_CASE("a face is not meshed again for sizes in the middle of its hole") {
  const auto model = make_torus(1, 0.3);
  SizeOptions options;
  options.size = 0.1;
  options.point_sizes = {{{1.3, 0, 0}, 0.08}};
  const TaskRunner runner(2);
  SizeFieldBuilder sizing(*model, options, runner);
  SurfaceMesher mesher(*model, runner);
  mesher.mesh(sizing.build({}).sizes);
  CHECK(mesher.remeshed() == 1);
  const Vec3 middle{0, 0, 0};
  const std::vector<SizeRefinement> refinements{{{middle, middle, middle}, 0.05}};
  const SizeField finer = sizing.build(refinements).sizes;
  CHECK(finer.size_at(middle) < 0.06);
  CHECK(mesh_digest(mesher.mesh(finer).mesh) == mesh_digest(mesh_surface(*model, finer, runner).mesh));
  CHECK(mesher.remeshed() == 0);
}

TEST_CASE("triangles are known again by face and corners, however they are numbered") {
  const TaskRunner runner(1);
  const Mesh mesh = mesh_uniformly(*make_box({0, 0, 0}, {1, 1, 1}), 0.3).mesh;
  const KnownTriangles known(mesh, runner);
  CHECK(KnownTriangles().find_new(mesh, runner).empty());
  Mesh other = mesh;
  std::ranges::reverse(other.tri_to_vert);
  std::ranges::reverse(other.tri_to_entity);
  for (auto& tri : other.tri_to_vert) std::ranges::rotate(tri, tri.begin() + 1);
  std::swap(other.tri_to_vert[0][0], other.tri_to_vert[0][1]);  // turned over
  other.tri_to_entity[1] += 1;
  std::vector<std::uint8_t> expected(mesh.tri_to_vert.size(), 0);
  expected[0] = expected[1] = 1;
  CHECK(known.find_new(other, runner) == expected);
}
