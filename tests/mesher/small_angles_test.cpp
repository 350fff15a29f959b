// Small dihedral angles: found, told from those that the surface forces, and counted.
#include <catch2/catch.hpp>

#include <numbers>
#include <random>

#include "core/tets/dihedral.hpp"
#include "core/tets/working_mesh.hpp"
#include "mesher/tets/acute_tets.hpp"
#include "mesher/volume/angle_causes.hpp"
#include "tests/support/tet_fixtures.hpp"

namespace tetloom {
namespace {

using namespace tet_tests;
using tets::WorkingMesh;

TEST_CASE("the smallest dihedral angle is found") {
  TetMesh regular = make_tets({{1, 1, 1}, {1, -1, -1}, {-1, 1, -1}, {-1, -1, 1}}, {{0, 1, 2, 3}});
  CHECK(tets::smallest_dihedral(regular, 0).angle == Approx(std::acos(1.0 / 3)));
  TetMesh wedge = make_tets({{0, 0, 0}, {1, 0, 0}, {0.5, 1, 0}, {0.5, std::cos(0.2), std::sin(0.2)}}, {{0, 1, 2, 3}});
  CHECK(tets::smallest_dihedral(wedge, 0).angle == Approx(0.2));
}

TEST_CASE("flat tets that the surface forces are warned of, with the place; others are not") {
  tets::OptimizeReport report;
  CHECK_FALSE(volume::warn_of_flat_tets(report));
  AcuteTet tet;
  tet.angle = 1e-9, tet.point = {1, 2, 3};
  report.acute_tets = {tet};
  CHECK_FALSE(volume::warn_of_flat_tets(report));
  report.acute_tets[0].cause = AngleCause::NarrowRegion;
  report.acute_tets[0].cause_length = 8e-15;
  report.acute_tets[0].entities = {{ModelFaceId(85), ""}, {ModelFaceId(93), ""}};
  const auto narrow = volume::warn_of_flat_tets(report);
  REQUIRE(narrow);
  CHECK(narrow->message.find("8e-15 wide") != std::string::npos);
  CHECK(narrow->entities.size() == 2);
  CHECK(narrow->point == Vec3{1, 2, 3});
  report.acute_tets[0].cause = AngleCause::SurfaceAngle;
  report.acute_tets[0].cause_length = 0;
  report.acute_tets[0].cause_angle = 0.5;
  CHECK(volume::warn_of_flat_tets(report)->message.find("angle of 0.5 degrees") != std::string::npos);
  report.acute_tets[0].angle = 1.5;
  CHECK_FALSE(volume::warn_of_flat_tets(report));
}

TEST_CASE("no tet of good quality has a small dihedral angle") {
  std::mt19937 random(11);
  const auto coordinate = [&] { return static_cast<double>(random()) / 4294967296.0; };
  for (int i = 0; i < 20000; ++i) {
    std::vector<Vec3> points(4);
    for (Vec3& p : points) p = {coordinate(), coordinate(), coordinate()};
    const TetMesh mesh = make_tets(points, {{0, 1, 2, 3}});
    const double angle = tets::smallest_dihedral(mesh, 0).angle, quality = quality_of(mesh, 0);
    if (quality * quality * quality > tets::largest_quality_with_dihedral(angle) * (1 + 1e-9)) {
      CAPTURE(i, angle, quality);
      FAIL("the bound is wrong");
    }
  }
}

TEST_CASE("a quick look finds all tets with a dihedral angle below one") {
  std::mt19937 random(12);
  const auto coordinate = [&] { return static_cast<double>(random()) / 4294967296.0; };
  std::size_t told_apart = 0;
  for (int i = 0; i < 5000; ++i) {
    std::vector<Vec3> points(4);
    for (Vec3& p : points) p = {coordinate(), coordinate(), i % 5 == 0 ? 0.0 : coordinate()};
    const TetMesh mesh = make_tets(points, {{0, 1, 2, 3}});
    const double angle = tets::smallest_dihedral(mesh, 0).angle;
    CAPTURE(i, angle);
    if (!tets::may_be_below(mesh, 0, std::cos(angle + 1e-6))) FAIL("a smaller angle is overlooked");
    told_apart += !tets::may_be_below(mesh, 0, std::cos(angle * 0.999));
  }
  CHECK(told_apart > 3900);
}

TEST_CASE("small angles are told from those that the surface forces") {
  TetMesh mesh = make_tets({{0, 0, 0}, {1, 0, 0}, {0.5, 1, 0}, {0.5, std::cos(0.1), std::sin(0.1)}}, {{0, 1, 2, 3}});
  WorkingMesh working(mesh, 4);
  tets::DihedralSummary summary = tets::summarize_dihedrals(working, 0.25);
  CHECK(summary.least == Approx(0.1));
  CHECK(summary.below == 1);
  CHECK(summary.forced() == 1);
  mesh.to_fixed[0] = 0;
  mesh.points[3] = {0.5, 0.9, 0.35};
  mesh.points[2] = {0.5, 1, 0.2};
  WorkingMesh free(mesh, 0);
  summary = tets::summarize_dihedrals(free, 1.2);
  CHECK(summary.below == 1);
}

TEST_CASE("the cause of a small angle is found: an angle of the surface, a poor triangle, close points, or none") {
  // Two tets share the 0.2 between the two surface triangles at the edge from (0, 0, 0) to (1, 0, 0).
  const auto at = [](double angle) { return Vec3{0.5, std::cos(angle), std::sin(angle)}; };
  TetMesh wedge = make_tets({{0, 0, 0}, {1, 0, 0}, at(0), at(0.1), at(0.2)}, {{0, 1, 2, 3}, {0, 1, 3, 4}});
  const auto summary_of = [](TetMesh& mesh, double least_wanted, std::size_t free_points = 0) {
    WorkingMesh working(mesh, static_cast<std::uint32_t>(mesh.points.size() - free_points));
    return tets::summarize_dihedrals(working, least_wanted);
  };
  const tets::DihedralSummary at_angle = summary_of(wedge, 0.25);
  CHECK(at_angle.below == 2);
  CHECK(at_angle.angles == 2);
  REQUIRE(at_angle.worst.size() == 2);
  CHECK(at_angle.worst[0].cause == AngleCause::SurfaceAngle);
  CHECK(at_angle.worst[0].angle == Approx(0.1 * 180 / 3.14159265358979));
  CHECK(at_angle.worst[0].cause_angle == Approx(0.2 * 180 / 3.14159265358979));
  REQUIRE(at_angle.worst[0].triangles.size() == 2);
  CHECK(summary_of(wedge, 0.15).angles == 0);  // the surface's angle alone would allow that

  // A tet with a flat face on the surface, and one that is flat although its face is not.
  const std::vector<Vec3> flat{{0, 0, 0}, {1, 0, 0}, {0.5, 0.9, 0}, {0.5, 0.3, 0.05}};
  TetMesh needle = make_tets({{0, 0, 0}, {1, 0, 0}, {0.5, 0.1, 0}, {0.5, 0.04, 0.005}}, {{0, 1, 2, 3}});
  needle.to_fixed[0] = 8;  // the face of the first three points
  const tets::DihedralSummary at_triangle = summary_of(needle, 0.25);
  CHECK(at_triangle.triangles == 1);
  CHECK(at_triangle.worst.at(0).cause_angle == Approx(std::atan(0.2) * 180 / 3.14159265358979));
  CHECK(at_triangle.worst.at(0).triangles.size() == 1);

  // The same flat tet at a point inside, which may go elsewhere.
  TetMesh free = make_tets({{0, 0, 0}, {9, 0, 0}, {4.5, 8, 0}, {4.5, 3, 7}, {4.5, 3, 0.2}},
                           {{0, 1, 2, 4}, {0, 1, 4, 3}, {4, 1, 2, 3}, {0, 4, 2, 3}});
  free.to_fixed[0] = 8;
  const tets::DihedralSummary not_forced = summary_of(free, 0.25, 1);
  CHECK(not_forced.below == 1);
  CHECK(not_forced.forced() == 0);
  CHECK(distance(not_forced.worst.at(0).point, Vec3{4.5, 2.75, 0.05}) < 1e-12);
  TetMesh narrow = make_tets(flat, {{0, 1, 2, 3}});  // the same where the fourth point is of the surface
  narrow.to_fixed[0] = 8;
  const tets::DihedralSummary at_region = summary_of(narrow, 0.25);
  CHECK(at_region.forced() == 1);
  CHECK(at_region.worst.at(0).cause == AngleCause::NarrowRegion);
  CHECK(at_region.worst.at(0).cause_length == Approx(0.05));

  TetMesh close = make_tets({{0, 0, 0}, {1, 0, 0}, {0.5, 0.9, 0}, {0, 0.01, 0.1}}, {{0, 1, 2, 3}});
  close.to_fixed[0] = 8;
  const tets::DihedralSummary at_points = summary_of(close, 0.25);
  CHECK(at_points.points == 1);
  CHECK(at_points.worst.at(0).points == std::vector<std::uint32_t>{0, 3});
}

TEST_CASE("angles above the least of another mesh and above those asked for are not looked at") {
  ShakenGrid grid = make_shaken_grid(4, 1, 0.5, 5);
  WorkingMesh working(grid.mesh, grid.fixed_points);
  const tets::DihedralSummary alone = tets::summarize_dihedrals(working, 0.01);
  CHECK(tets::summarize_dihedrals(working, 0.01, alone.least + 0.1).least == alone.least);
  CHECK(tets::summarize_dihedrals(working, 0.01, alone.least / 2).least == alone.least / 2);
  const tets::DihedralSummary told = tets::summarize_dihedrals(working, 0.9, alone.least / 2);
  CHECK(told.below == tets::summarize_dihedrals(working, 0.9).below);
  CHECK(told.below > 0);
}

TEST_CASE("of many small angles the worst are told, in order") {
  const ShakenGrid grid = make_shaken_grid(6, 1, 0.9, 5);
  TetMesh mesh = grid.mesh;
  WorkingMesh working(mesh, grid.fixed_points);
  const tets::DihedralSummary summary = tets::summarize_dihedrals(working, 1.1);
  CHECK(summary.below > 1000);
  REQUIRE(summary.worst.size() == kMostAcuteTets);
  std::vector<double> angles;
  for (std::uint32_t t = 0; t < mesh.size(); ++t)
    angles.push_back(tets::smallest_dihedral(mesh, t).angle * 180 / 3.14159265358979324);
  std::sort(angles.begin(), angles.end());
  for (std::size_t i = 0; i < kMostAcuteTets; ++i) REQUIRE(summary.worst[i].angle == Approx(angles[i]));
}

}  // namespace
}  // namespace tetloom
