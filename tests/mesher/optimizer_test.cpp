#include "mesher/tets/optimizer.hpp"
#include "tetloom/tasks.hpp"

#include <catch2/catch.hpp>

#include "core/tets/deep_point.hpp"
#include "core/tets/dihedral.hpp"
#include "mesher/tets/edge_removal.hpp"
#include "mesher/tets/newton_smoothing.hpp"
#include "mesher/tets/point_insertion.hpp"
#include "mesher/tets/vertex_removal.hpp"
#include "tests/support/tet_fixtures.hpp"
#include "tetloom/error.hpp"

namespace tetloom {
namespace {

using namespace tet_tests;
using tets::EdgeVerdict;
using tets::MoveVerdict;
using tets::WorkingMesh;

TEST_CASE("points that are given up are filled by the last ones") {
  TetMesh mesh = make_octahedron({0, 0, 0});
  const Vec3 last = mesh.points[6];
  const std::uint32_t unused = static_cast<std::uint32_t>(mesh.points.size());
  for (int i = 0; i < 3; ++i) mesh.points.push_back({double(i), 9, 9});
  WorkingMesh working(mesh, 6);
  working.give_up_point(unused + 2);
  working.give_up_point(unused);
  working.finish();
  CHECK(mesh.points.size() == 8);
  CHECK(mesh.points[6] == last);
  CHECK(mesh.points[7] == Vec3{1, 9, 9});
  CHECK(tets::find_fault(mesh) == "");
}

TEST_CASE("optimising random meshes keeps what must stay and lowers no minimum") {
  for (unsigned seed = 0; seed < 24; ++seed) {
    const int regions = seed % 2 == 0 ? 1 : 2;
    ShakenGrid grid = make_shaken_grid(5, regions, 0.3 + 0.009 * seed, seed);
    REQUIRE(volume_of_region(grid.mesh, 0) == Approx(regions == 1 ? 125 : 50));
    REQUIRE(tets::find_fault(grid.mesh) == "");
    CAPTURE(seed);
    TetMesh mesh = grid.mesh;
    tets::OptimizeOptions options;
    options.fixed_points = grid.fixed_points;
    const SizeField sizes = SizeField::uniform(1);
    if (seed % 3 == 0) options.sizes = &sizes;
    const tets::OptimizeReport report = tets::optimize(mesh, options, TaskRunner(1));
    CHECK(tets::find_fault(mesh) == "");
    CHECK(least_quality(mesh) >= least_quality(grid.mesh) * (1 - 1e-6));
    CHECK(report.least == Approx(least_quality(mesh)).epsilon(1e-5));
    CHECK(report.least_before == Approx(least_quality(grid.mesh)).epsilon(1e-5));
    CHECK(report.mean > report.mean_before);
    CHECK(report.vertices_moved > 0);
    for (int r = 0; r < regions; ++r) {
      const auto region = static_cast<std::uint32_t>(r);
      CHECK(volume_of_region(mesh, region) == Approx(volume_of_region(grid.mesh, region)).epsilon(1e-12));
    }
    CHECK(fixed_faces(mesh) == fixed_faces(grid.mesh));
    for (std::uint32_t v = 0; v < grid.fixed_points; ++v) CHECK(mesh.points[v] == grid.mesh.points[v]);
    TetMesh again = grid.mesh;
    tets::optimize(again, options, TaskRunner(2));
    CHECK(same(mesh, again));
  }
}

TEST_CASE("each operation tried everywhere keeps the invariants and lowers no minimum") {
  for (unsigned seed = 0; seed < 12; ++seed) {
    const int regions = seed % 2 == 0 ? 1 : 2;
    ShakenGrid grid = make_shaken_grid(4, regions, 0.5, 100 + seed);
    TetMesh& mesh = grid.mesh;
    CAPTURE(seed);
    const auto faces = fixed_faces(mesh);
    const double volume = volume_of_region(mesh, 0);
    double least = least_quality(mesh);
    WorkingMesh working(mesh, grid.fixed_points);
    const TaskRunner runner(1);
    const auto check = [&](const char* stage) {
      CAPTURE(stage);
      CHECK(tets::find_fault(mesh) == "");
      CHECK(least_quality(mesh) >= least * (1 - 1e-6));
      least = least_quality(mesh);
      CHECK(fixed_faces(mesh) == faces);
      CHECK(volume_of_region(mesh, 0) == Approx(volume).epsilon(1e-12));
      for (std::uint32_t t = 0; t < mesh.size(); ++t) {
        if (!mesh.is_dead(t)) CHECK(std::cbrt(working.quality(t)) == Approx(quality_of(mesh, t)).epsilon(1e-5));
      }
    };
    tets::insert_points(working, 0.9, runner), check("insertion");
    tets::remove_vertices(working, 0.9, runner), check("vertex removal");
    tets::remove_edges(working, 0.9, runner), check("edge removal");
    tets::move_vertices(working, 1, runner), check("motion");
    tets::insert_points(working, 0.5, runner), check("insertion into what is left");
    tets::remove_vertices(working, 0.5, runner), check("vertex removal from what is left");
    working.finish();
    CHECK(tets::find_fault(mesh) == "");
    std::vector<bool> used(mesh.points.size());
    for (const std::uint32_t v : mesh.to_vert) used[v] = true;
    CHECK(std::find(used.begin(), used.end(), false) == used.end());
  }
}

TEST_CASE("a mesh that is far from the origin is optimised as well") {
  ShakenGrid grid = make_shaken_grid(4, 1, 0.5, 7);
  for (Vec3& p : grid.mesh.points) p += Vec3{1e9, -3e9, 2e9};
  REQUIRE(tets::find_fault(grid.mesh).empty());
  const double least = least_quality(grid.mesh);
  tets::OptimizeOptions options;
  options.fixed_points = grid.fixed_points;
  tets::optimize(grid.mesh, options, TaskRunner(1));
  CHECK(tets::find_fault(grid.mesh) == "");
  CHECK(least_quality(grid.mesh) > least);
}

TEST_CASE("the unit of length does not matter") {
  const ShakenGrid grid = make_shaken_grid(4, 1, 0.5, 9);
  tets::OptimizeOptions options;
  options.fixed_points = grid.fixed_points;
  TetMesh reference = grid.mesh;
  tets::optimize(reference, options, TaskRunner(1));
  for (const double unit : {0x1p-40, 0x1p40}) {
    TetMesh mesh = grid.mesh;
    for (Vec3& p : mesh.points) p *= unit;
    tets::optimize(mesh, options, TaskRunner(1));
    for (Vec3& p : mesh.points) p *= 1 / unit;
    CHECK(same(mesh, reference));
  }
}

TEST_CASE("a host that cancels gets an error and a mesh that is whole") {
  ShakenGrid grid = make_shaken_grid(4, 1, 0.5, 3);
  CancelToken token;
  token.cancel();
  const TaskRunner runner(1, Host{{}, &token});
  tets::OptimizeOptions options;
  options.fixed_points = grid.fixed_points;
  CHECK_THROWS_AS(tets::optimize(grid.mesh, options, runner), Error);
  CHECK(tets::find_fault(grid.mesh) == "");
}

TEST_CASE("higher goals leave fewer tets below them, and without rounds no point comes or goes") {
  const ShakenGrid grid = make_shaken_grid(8, 1, 0.9, 7);
  const auto optimized = [&](const QualityGoals& goals) {
    TetMesh mesh = grid.mesh;
    tets::OptimizeOptions options;
    options.fixed_points = grid.fixed_points;
    options.goals = goals;
    const tets::OptimizeReport report = tets::optimize(mesh, options, TaskRunner(1));
    std::size_t below = 0, acute = 0;
    for (std::uint32_t t = 0; t < mesh.size(); ++t) {
      below += quality_of(mesh, t) < goals.mean_ratio;
      acute += tets::smallest_dihedral(mesh, t).angle < goals.dihedral * 3.14159265358979 / 180;
    }
    CHECK(report.below_goal == below);
    CHECK(report.below_dihedral == acute);
    return std::pair(mesh, report);
  };
  const auto count_below = [](const TetMesh& mesh, double goal) {
    std::size_t count = 0;
    for (std::uint32_t t = 0; t < mesh.size(); ++t) count += quality_of(mesh, t) < goal;
    return count;
  };
  const auto [usual, usual_report] = optimized({});
  const auto [ratio, ratio_report] = optimized({15, 0.65, 2});
  CHECK(ratio_report.below_goal < count_below(usual, 0.65));
  CHECK(optimized({15, 0.65, 8}).second.below_goal <= ratio_report.below_goal);
  const auto [none, none_report] = optimized({30, 0.65, 0});
  CHECK(none_report.points_inserted + none_report.vertices_removed == 0);
  CHECK(optimized({30, 0.5, 2}).second.below_dihedral < none_report.below_dihedral);
}

TEST_CASE("dead tets of the input are dropped") {
  ShakenGrid grid = make_shaken_grid(3, 1, 0.4, 5);
  TetMesh mesh = grid.mesh;
  for (int i = 0; i < 3; ++i) {
    for (int k = 0; k < 4; ++k) mesh.to_vert.push_back(kNone), mesh.to_neighbor.push_back({});
    mesh.to_region.push_back(0);
    mesh.to_fixed.push_back(0);
  }
  tets::OptimizeOptions options;
  options.fixed_points = grid.fixed_points;
  tets::optimize(mesh, options, TaskRunner(1));
  CHECK(tets::find_fault(mesh) == "");
  for (std::uint32_t t = 0; t < mesh.size(); ++t) CHECK_FALSE(mesh.is_dead(t));
  CHECK(volume_of_region(mesh, 0) == Approx(27));
}

TEST_CASE("an empty mesh is optimal") {
  TetMesh mesh;
  CHECK_NOTHROW(tets::optimize(mesh, {}, TaskRunner(1)));
  const SizeField sizes = SizeField::uniform(1);
  tets::OptimizeOptions options;
  options.sizes = &sizes;
  CHECK_NOTHROW(tets::optimize(mesh, options, TaskRunner(1)));
}

TEST_CASE("optimising refuses options out of range") {
  const auto code_of = [](const tets::OptimizeOptions& options) {
    TetMesh mesh = make_octahedron({0, 0, 0});
    try {
      tets::optimize(mesh, options, TaskRunner(1));
    } catch (const Error& error) {
      return error.code();
    }
    return ErrorCode::Internal;
  };
  tets::OptimizeOptions many, low, high, wide, acute, backwards, endless;
  many.fixed_points = 8;
  low.goals.mean_ratio = -0.1;
  high.goals.mean_ratio = 0.91;
  wide.goals.dihedral = 61;
  acute.goals.dihedral = std::nan("");
  backwards.goals.rounds = -1;
  endless.goals.rounds = 101;
  for (const auto& options : {many, low, high, wide, acute, backwards, endless})
    CHECK(code_of(options) == ErrorCode::InvalidArgument);
}

}  // namespace
}  // namespace tetloom
