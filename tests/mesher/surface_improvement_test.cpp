#include "mesher/tets/surface_improvement.hpp"
#include "mesher/volume/volume_mesher.hpp"
#include "tetloom/tasks.hpp"

#include <catch2/catch.hpp>

#include "mesher/tets/surface_slide.hpp"
#include "mesher/tets/surface_swap.hpp"
#include "tests/mesher/surface_fixtures.hpp"
#include "tests/mesher/volume_surfaces.hpp"
#include "tests/support/analytic_model.hpp"

namespace tetloom {
namespace {

using namespace tet_tests;
using tets::SlideVerdict;
using tets::SwapVerdict;

SwapVerdict try_swap(TetMesh& mesh, TestSurface& surface) {
  tets::WorkingMesh working(mesh, static_cast<std::uint32_t>(mesh.points.size()));
  tets::ChangeableSurface view = surface.view();
  tets::SurfaceTriangles triangles(view.tri_to_vert, mesh.points.size());
  const SwapVerdict verdict = tets::SurfaceSwapper(working, view, triangles, 1).swap_edge_of(0);
  if (verdict == SwapVerdict::Swapped) working.finish();
  return verdict;
}

void check_refused(TetMesh mesh, TestSurface surface, SwapVerdict verdict) {
  const TetMesh before = mesh;
  const auto triangles = surface.tri_to_vert;
  CHECK(try_swap(mesh, surface) == verdict);
  CHECK(same(mesh, before));
  CHECK(surface.tri_to_vert == triangles);
}

TEST_CASE("a long edge of the surface gives way to the other diagonal") {
  TetMesh mesh = make_diamond();
  TestSurface surface = flat_surface(mesh);
  const double volume = volume_of_region(mesh, 0), least = least_quality(mesh);
  CHECK(try_swap(mesh, surface) == SwapVerdict::Swapped);
  CHECK(mesh.size() == 2);
  CHECK(tets::find_fault(mesh) == "");
  CHECK(least_quality(mesh) > least);
  CHECK(volume_of_region(mesh, 0) == Approx(volume));
  CHECK(surface.matches(mesh));
  CHECK(surface.area_of(mesh, 0) == Approx(1));
}

TEST_CASE("a swap between two regions changes both alike") {
  TetMesh mesh = make_diamond({0, 0, 0.8}, true);
  TestSurface surface = flat_surface(mesh);
  const double below = volume_of_region(mesh, 0), above = volume_of_region(mesh, 1);
  CHECK(try_swap(mesh, surface) == SwapVerdict::Swapped);
  CHECK(mesh.size() == 4);
  CHECK(tets::find_fault(mesh) == "");
  CHECK(volume_of_region(mesh, 0) == Approx(below));
  CHECK(volume_of_region(mesh, 1) == Approx(above));
  CHECK(surface.matches(mesh));
}

TEST_CASE("a flat tet on the surface vanishes") {
  // One with two triangles of the surface, over the diamond's tets as they are after a swap.
  const std::vector<Vec3> points{{-1, 0, 1e-9}, {1, 0, 1e-9}, {0, 0.5, 0}, {0, -0.5, 0}, {0, 0, 0.8}};
  TetMesh mesh = make_tets(points, {{0, 1, 2, 3}, {0, 3, 2, 4}, {3, 1, 2, 4}});
  mesh.points[0].z = mesh.points[1].z = -1e-9;
  mesh = make_tets({mesh.points.begin(), mesh.points.end()}, {{0, 1, 2, 3}, {0, 3, 2, 4}, {3, 1, 2, 4}});
  TestSurface surface = flat_surface(mesh);
  CHECK(try_swap(mesh, surface) == SwapVerdict::Swapped);
  CHECK(mesh.size() == 2);
  CHECK(tets::find_fault(mesh) == "");
  CHECK(surface.matches(mesh));
}

TEST_CASE("pieces of model edges are not swapped") {
  TetMesh mesh = make_diamond();
  TestSurface surface = flat_surface(mesh);
  surface.is_kept = [](std::uint32_t, std::uint32_t) { return true; };
  check_refused(mesh, surface, SwapVerdict::OnModelEdge);
  surface.is_kept = {};
  for (std::uint32_t t = 0; t < surface.tri_to_face.size(); ++t) surface.tri_to_face[t] = t;
  check_refused(mesh, surface, SwapVerdict::OnModelEdge);
}

TEST_CASE("a surface edge that is there already is not made again") {
  TetMesh mesh = make_tets({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0.3, 0.3, 0.01}}, {{0, 1, 2, 3}});
  TestSurface surface = flat_surface(mesh);
  surface.tri_to_face.assign(4, 0);
  check_refused(mesh, surface, SwapVerdict::EdgeExists);
}

TEST_CASE("an edge with more tets than there is room for is not swapped") {
  TetMesh mesh = make_half_ring(13);
  check_refused(mesh, flat_surface(mesh), SwapVerdict::LongRing);
}

TEST_CASE("tets without a surface edge are not asked") {
  TetMesh mesh = make_ring(5, 3);
  TestSurface surface;
  check_refused(mesh, surface, SwapVerdict::NotOnSurface);
}

TEST_CASE("an edge stays where its surface is bent or in its own way") {
  TetMesh mesh = make_diamond();
  TestSurface surface = flat_surface(mesh);
  surface.is_clear = [](const tets::SurfaceChange&) { return false; };
  check_refused(mesh, surface, SwapVerdict::Blocked);
  mesh.points[2].z = mesh.points[3].z = 0.1;
  surface.is_clear = {};
  check_refused(mesh, surface, SwapVerdict::OffModel);
  // The model is the roof over the diamond, which the new edge would cut off.
  surface.project = [](ModelEntity, const Vec3& x) {
    const Vec3 normal = normalized(Vec3{0, x.y > 0 ? 0.2 : -0.2, -1});
    return SurfaceSpot{{x.x, x.y, 0.2 * std::abs(x.y)}, normal};
  };
  check_refused(mesh, surface, SwapVerdict::OffModel);
  surface.project = [](ModelEntity, const Vec3&) { return std::nullopt; };
  check_refused(mesh, surface, SwapVerdict::OffModel);
}

TEST_CASE("swaps of random diamonds either raise the minimum or change nothing") {
  std::mt19937 random(11);
  const auto number = [&](double lo, double hi) {
    return lo + (hi - lo) * (static_cast<double>(random()) / 4294967296.0);
  };
  std::map<SwapVerdict, int> counts;
  for (int i = 0; i < 2000; ++i) {
    TetMesh mesh = make_diamond({number(-2, 2), number(-5, 5), number(0.05, 4)}, false, number(0.1, 10));
    TestSurface surface = flat_surface(mesh);
    const TetMesh before = mesh;
    const SwapVerdict verdict = try_swap(mesh, surface);
    ++counts[verdict];
    if (verdict == SwapVerdict::Swapped) {
      CHECK(tets::find_fault(mesh) == "");
      CHECK(least_quality(mesh) > least_quality(before));
      CHECK(surface.matches(mesh));
    } else {
      CHECK(same(mesh, before));
    }
  }
  CHECK(counts[SwapVerdict::Swapped] > 0);
  CHECK(counts[SwapVerdict::NoGain] > 0);
  CHECK(counts[SwapVerdict::PoorTriangles] > 0);
}

SlideVerdict try_slide(CubeGrid& grid, std::uint32_t vertex) {
  tets::WorkingMesh working(grid.mesh, grid.fixed_points);
  tets::ChangeableSurface view = grid.surface.view();
  tets::SurfaceTriangles triangles(view.tri_to_vert, grid.fixed_points);
  std::uint32_t code = 0;
  while (grid.mesh.to_vert[code] != vertex) ++code;
  return tets::SurfaceSlider(working, view, triangles, 0.2).slide(code / 4, code % 4);
}

TEST_CASE("a vertex slides back within its face and along its edge, and a corner stays") {
  CubeGrid grid = make_cube_grid(4, 1, 0, 1);
  const double least = least_quality(grid.mesh);
  const std::uint32_t inside = grid.find({2, 2, 4}), along = grid.find({2, 4, 4}), corner = grid.find({4, 4, 4});
  grid.mesh.points[inside] += Vec3{0.6, 0.3, 0};
  const double shaken = least_quality(grid.mesh);
  CHECK(try_slide(grid, inside) == SlideVerdict::Moved);
  CHECK(grid.mesh.points[inside].z == 4);
  CHECK(least_quality(grid.mesh) > shaken);
  grid.mesh.points[inside] = {2, 2, 4};
  grid.mesh.points[along].x += 0.6;
  CHECK(try_slide(grid, along) == SlideVerdict::Moved);
  CHECK(grid.mesh.points[along].x < 2.5);
  CHECK(grid.mesh.points[along].y == 4);
  CHECK(grid.mesh.points[along].z == 4);
  CHECK(try_slide(grid, corner) == SlideVerdict::Stays);
  CHECK(least_quality(grid.mesh) <= least);
}

TEST_CASE("a vertex stays where the model, the surface or its entity forbid a slide") {
  CubeGrid grid = make_cube_grid(4, 1, 0, 1);
  const std::uint32_t vertex = grid.find({2, 2, 4});
  grid.mesh.points[vertex] += Vec3{0.6, 0.3, 0};
  const TetMesh before = grid.mesh;
  const auto expect = [&](SlideVerdict verdict) {
    CHECK(try_slide(grid, vertex) == verdict);
    CHECK(same(grid.mesh, before));
  };
  grid.surface.is_clear = [](const tets::SurfaceChange&) { return false; };
  expect(SlideVerdict::Folds);
  grid.surface.is_clear = {};
  grid.surface.project = [](ModelEntity, const Vec3&) { return std::nullopt; };
  expect(SlideVerdict::OffModel);
  grid.surface.project = {};
  expect(SlideVerdict::Stays);
  grid.surface.project = project_on_cube(4);
  grid.surface.point_to_entity[vertex] = ModelFaceId(0);
  expect(SlideVerdict::Stays);
  grid.surface.point_to_entity[vertex] = ModelEdgeId(0);
  expect(SlideVerdict::Stays);
  grid.surface.point_to_entity[vertex] = {};
  expect(SlideVerdict::Stays);
}

tets::OptimizeReport improve(CubeGrid& grid, bool keep_points = false) {
  tets::OptimizeOptions options;
  options.keep_points = keep_points;
  options.fixed_points = grid.fixed_points;
  options.goals.dihedral = 30;
  tets::OptimizeReport report;
  improve_surface(grid.mesh, grid.surface.view(), options, report, TaskRunner(1));
  return report;
}

TEST_CASE("shaken cubes of one and two regions get better, with their shape, faces and interface kept") {
  for (const int regions : {1, 2}) {
    for (const unsigned seed : {1u, 2u, 3u}) {
      INFO("regions " << regions << ", seed " << seed);
      CubeGrid grid = make_cube_grid(6, regions, 0.6, seed);
      REQUIRE(tets::find_fault(grid.mesh) == "");
      const double least = least_quality(grid.mesh);
      CubeGrid again = grid;
      const tets::OptimizeReport report = improve(grid);
      CHECK(report.vertices_slid > 0);
      CHECK(tets::find_fault(grid.mesh) == "");
      CHECK(least_quality(grid.mesh) > least);
      CHECK(grid.surface.matches(grid.mesh));
      CHECK(grid.misplaced_points() == 0);
      for (int r = 0; r < regions; ++r) CHECK(volume_of_region(grid.mesh, r) == Approx(216.0 / regions));
      for (std::uint32_t face = 0; face < 6u + (regions == 2); ++face)
        CHECK(grid.surface.area_of(grid.mesh, face) == Approx(36));
      improve(again);
      CHECK(same(grid.mesh, again.mesh));
      CHECK(grid.surface.tri_to_vert == again.surface.tri_to_vert);
    }
  }
}

std::size_t count_below(const TetMesh& mesh, double mean_ratio) {
  std::size_t count = 0;
  for (std::uint32_t t = 0; t < mesh.size(); ++t) count += quality_of(mesh, t) < mean_ratio;
  return count;
}

TEST_CASE("where sizes vary, tets that are merely fair get better with the surface as well") {
  CubeGrid grid = make_cube_grid(6, 2, 0.3, 7);
  tets::OptimizeOptions options;
  options.fixed_points = grid.fixed_points;
  options.goals = {.dihedral = 0, .mean_ratio = 0.1, .rounds = 2};
  tets::OptimizeReport report;
  const CubeGrid before = grid;
  report.least = least_quality(grid.mesh);
  CHECK(tets::quality_to_improve(options) < 0.01);
  improve_surface(grid.mesh, grid.surface.view(), options, report, TaskRunner(1));
  CHECK(same(grid.mesh, before.mesh));  // nothing is poor
  const SizeField sizes = SizeField::uniform(1);
  options.sizes = &sizes;
  CHECK(tets::quality_to_improve(options) == Approx(0.8 * 0.8 * 0.8));
  improve_surface(grid.mesh, grid.surface.view(), options, report, TaskRunner(1));
  CHECK(report.vertices_slid > 0);
  CHECK(count_below(grid.mesh, 0.75) < count_below(before.mesh, 0.75));
  CHECK(least_quality(grid.mesh) >= least_quality(before.mesh));
  CHECK(tets::find_fault(grid.mesh) == "");
  CHECK(grid.surface.matches(grid.mesh));
  CHECK(grid.misplaced_points() == 0);
  options.goals.rounds = 0;
  CHECK(tets::quality_to_improve(options) < 0.01);
}

TEST_CASE("points keep their numbers where it is asked, also those that no tet has any more") {
  std::size_t dropped = 0;
  for (unsigned seed = 1; seed <= 8; ++seed) {
    CAPTURE(seed);
    CubeGrid grid = make_cube_grid(6, 1, 0.75, seed), kept = grid;
    const std::size_t before = grid.mesh.points.size();
    const tets::OptimizeReport report = improve(grid), same_report = improve(kept, true);
    CHECK(kept.mesh.points.size() >= before);
    CHECK(kept.mesh.points.size() >= grid.mesh.points.size());
    dropped += kept.mesh.points.size() - grid.mesh.points.size();
    // The same tets, with other numbers of points only.
    CHECK(report.vertices_removed == same_report.vertices_removed);
    REQUIRE(kept.mesh.size() == grid.mesh.size());
    for (std::uint32_t tet = 0; tet < grid.mesh.size(); ++tet)
      for (int corner = 0; corner < 4; ++corner)
        REQUIRE(kept.mesh.point_of(tet, corner) == grid.mesh.point_of(tet, corner));
  }
  CHECK(dropped > 0);
}

TEST_CASE("without a model no vertex moves and what lies in a plane is swapped") {
  CubeGrid grid = make_cube_grid(6, 2, 0.75, 4);
  grid.surface.project = {};
  const std::vector<Vec3> points(grid.mesh.points.begin(), grid.mesh.points.begin() + grid.fixed_points);
  const tets::OptimizeReport report = improve(grid);
  CHECK(report.vertices_slid == 0);
  CHECK(report.edges_swapped > 0);
  CHECK(tets::find_fault(grid.mesh) == "");
  CHECK(grid.surface.matches(grid.mesh));
  CHECK(std::equal(points.begin(), points.end(), grid.mesh.points.begin()));
}

using volume_tests::VolumeMesh;

// A ball whose surface points are shaken on the sphere.
struct ShakenBall {
  volume_tests::Surface surface = volume_tests::ball_surface(3, {}, 0, [](const Vec3&) { return 1.0; });
  std::unique_ptr<GeometricModel> model = test_models::make_sphere({}, 1);
  SizeField sizes = SizeField::uniform(0.2);
  std::vector<ModelEntity> point_to_entity;

  ShakenBall() {
    std::mt19937 random(5);
    const auto amount = [&] { return 0.13 * (static_cast<double>(random()) / 4294967296.0 - 0.5); };
    for (Vec3& p : surface.points) p = normalized(p + Vec3{amount(), amount(), amount()});
    point_to_entity.assign(surface.points.size(), ModelFaceId(0));
  }
  VolumeMesh fill(bool improve, int threads = 1) const {
    VolumeInput input = surface.input(sizes);
    input.model = model.get();
    input.point_to_entity = point_to_entity;
    return volume_tests::fill_volume(input, {.worker = {}, .improve_surface = improve}, TaskRunner(threads));
  }
};

TEST_CASE("a volume hands back how its surface has changed, true to the model") {
  const ShakenBall ball;
  const VolumeMesh mesh = ball.fill(true);
  REQUIRE(mesh.errors.empty());
  REQUIRE(mesh.moved_points.size() > 0);
  volume_tests::Surface changed = ball.surface;
  for (const auto& moved : mesh.moved_points) {
    changed.points[moved.point] = moved.to;
    CHECK(norm(moved.to) == Approx(1).epsilon(1e-12));
  }
  for (const auto& triangle : mesh.changed_triangles) changed.tri_to_vert[triangle.triangle] = triangle.verts;
  CHECK(volume_tests::check_filling(changed, mesh)[0] == Approx(4.18879).epsilon(0.03));
  CHECK(find_self_intersections({changed.points, changed.tri_to_vert, {}}, TaskRunner(1)).empty());
  const VolumeMesh kept = ball.fill(false);
  CHECK(mesh.figures.optimizer.below_dihedral <= kept.figures.optimizer.below_dihedral);
  CHECK(mesh.figures.optimizer.least >= kept.figures.optimizer.least);
}

TEST_CASE("a surface that has to stay stays") {
  const ShakenBall ball;
  const VolumeMesh mesh = ball.fill(false);
  CHECK(mesh.moved_points.empty());
  CHECK(mesh.changed_triangles.empty());
  volume_tests::check_filling(ball.surface, mesh);
}

TEST_CASE("a changed surface does not depend on the threads") {
  const ShakenBall ball;
  const VolumeMesh one = ball.fill(true, 1), two = ball.fill(true, 2);
  CHECK(one.tet_to_vert == two.tet_to_vert);
  CHECK(one.new_points == two.new_points);
  REQUIRE(one.moved_points.size() == two.moved_points.size());
  for (std::size_t i = 0; i < one.moved_points.size(); ++i) CHECK(one.moved_points[i].to == two.moved_points[i].to);
}

}  // namespace
}  // namespace tetloom
