// Searches for larger dihedral angles, on single stars and cavities and on whole meshes.
#include "mesher/tets/angle_search.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>

#include "core/tets/dihedral.hpp"
#include "mesher/tets/surface_slide.hpp"
#include "tests/mesher/surface_fixtures.hpp"

namespace tetloom {
namespace {

using namespace tet_tests;

double least_angle_of(const TetMesh& mesh, std::span<const std::uint32_t> tets) {
  double least = 10;
  for (const std::uint32_t t : tets)
    if (!mesh.is_dead(t)) least = std::min(least, tets::smallest_dihedral(mesh, t).angle);
  return least;
}

std::vector<std::uint32_t> tets_at(const TetMesh& mesh, std::uint32_t vertex) {
  std::vector<std::uint32_t> found;
  for (std::size_t code = 0; code < mesh.to_vert.size(); ++code)
    if (mesh.to_vert[code] == vertex) found.push_back(static_cast<std::uint32_t>(code / 4));
  return found;
}

std::vector<std::uint32_t> changed_tets(const TetMesh& before, const TetMesh& after) {
  std::vector<std::uint32_t> changed;
  for (std::uint32_t t = 0; t < before.size(); ++t)
    if (!std::equal(&before.to_vert[t * 4], &before.to_vert[t * 4] + 4, &after.to_vert[t * 4])) changed.push_back(t);
  return changed;
}

// Cubes made flat.
CubeGrid make_layer(double height) {
  CubeGrid grid = make_cube_grid(2, 1, 0, 1);
  for (Vec3& x : grid.mesh.points) x.z *= height;
  return grid;
}

TEST_CASE("the cosine of a tet's smallest dihedral angle is that of the tet in a mesh") {
  const ShakenGrid grid = make_shaken_grid(3, 1, 0.7, 5);
  for (std::uint32_t t = 0; t < grid.mesh.size(); ++t) {
    const auto at = [&](int corner) { return grid.mesh.point_of(t, corner); };
    CHECK(tets::cosine_of_smallest_dihedral(at(0), at(1), at(2), at(3)) ==
          Approx(std::cos(tets::smallest_dihedral(grid.mesh, t).angle)));
  }
}

TEST_CASE("a vertex moves to where the smallest angle of its star is larger, or stays") {
  int moves = 0;
  for (unsigned seed = 1; seed <= 10; ++seed) {
    ShakenGrid grid = make_shaken_grid(4, 1, 0.6, seed);
    TetMesh& mesh = grid.mesh;
    REQUIRE(tets::find_fault(mesh) == "");
    REQUIRE(volume_of_region(mesh, 0) == Approx(64));
    tets::WorkingMesh working(mesh, grid.fixed_points);
    for (std::uint32_t t = 0; t < mesh.size(); ++t) {
      const std::uint32_t corner = t % 4, vertex = mesh.to_vert[t * 4 + corner];
      const std::vector<std::uint32_t> star = tets_at(mesh, vertex);
      const TetMesh before = mesh;
      if (!tets::move_for_angle(working, t, corner, 1e-6)) {
        CHECK(same(mesh, before));
        continue;
      }
      ++moves;
      CHECK(vertex >= grid.fixed_points);
      CHECK(least_angle_of(mesh, star) > least_angle_of(before, star));
      for (const std::uint32_t tet : star)
        CHECK(static_cast<double>(working.quality(tet)) == Approx(tets::cube(quality_of(mesh, tet))).epsilon(1e-5));
    }
    CHECK(tets::find_fault(mesh) == "");
    CHECK(volume_of_region(mesh, 0) == Approx(64));
  }
  CHECK(moves > 50);
}

TEST_CASE("a point is put where it makes the smallest angle around an edge larger, or nowhere") {
  int insertions = 0;
  for (unsigned seed = 1; seed <= 10; ++seed) {
    ShakenGrid grid = make_shaken_grid(6, 1, 0.5, seed);
    TetMesh& mesh = grid.mesh;
    const double volume = volume_of_region(mesh, 0);
    REQUIRE(volume == Approx(216));
    const auto faces = fixed_faces(mesh);
    tets::WorkingMesh working(mesh, grid.fixed_points);
    for (std::uint32_t t = 0; t < mesh.size(); ++t) {
      if (mesh.is_dead(t) || tets::smallest_dihedral(mesh, t).angle > 0.6) continue;
      const TetMesh before = mesh;
      if (!tets::insert_for_angle(working, t, 1e-6)) {
        CHECK(same(mesh, before));
        continue;
      }
      ++insertions;
      const auto point = static_cast<std::uint32_t>(mesh.points.size() - 1);
      CHECK(mesh.points.size() == before.points.size() + 1);
      CHECK(least_angle_of(mesh, tets_at(mesh, point)) > least_angle_of(before, changed_tets(before, mesh)));
    }
    working.finish();
    CHECK(tets::find_fault(mesh) == "");
    CHECK(volume_of_region(mesh, 0) == Approx(volume));
    CHECK(fixed_faces(mesh) == faces);
  }
  CHECK(insertions > 5);
}

TEST_CASE("beside a needle of the surface a point comes near, where the angle is larger than the needle's") {
  // The needle 0 1 2 in the plane z = 0, between other triangles of it, below a ring around the edge from its tip up.
  const std::vector<Vec3> points{{0, 0, 0},     {1, 0.02, 0},   {1, -0.02, 0}, {0.5, 0, 0.6},
                                 {0.3, 0.8, 0}, {0.3, -0.8, 0}, {-0.7, 0, 0}};
  TetMesh mesh = make_tets(points, {{0, 2, 1, 3}, {0, 1, 4, 3}, {0, 4, 6, 3}, {0, 6, 5, 3}, {0, 5, 2, 3}});
  REQUIRE(tets::find_fault(mesh) == "");
  const double before = tets::smallest_dihedral(mesh, 0).angle;
  tets::WorkingMesh working(mesh, 7);
  CHECK(tets::insert_for_angle(working, 0, 1e-6));
  working.finish();
  CHECK(tets::find_fault(mesh) == "");
  REQUIRE(mesh.points.size() == 8);
  CHECK(mesh.points[7].z < 0.3);
  for (std::uint32_t t = 0; t < mesh.size(); ++t) CHECK(tets::smallest_dihedral(mesh, t).angle > 1.5 * before);
}

TEST_CASE("a vertex of a flat layer slides within its face to where angles are larger, as far as quality is kept") {
  CubeGrid grid = make_layer(0.05);
  const auto layer = [&](ModelEntity entity, const Vec3& x) {
    auto spot = project_on_cube(2)(entity, {x.x, x.y, x.z / 0.05});
    spot->point.z *= 0.05;
    return spot;
  };
  grid.surface.project = layer;
  const std::uint32_t vertex = grid.find({1, 1, 0.1});
  REQUIRE(vertex < grid.fixed_points);
  grid.mesh.points[vertex] += Vec3{0.4, 0.2, 0};
  const std::vector<std::uint32_t> star = tets_at(grid.mesh, vertex);
  const TetMesh before = grid.mesh;
  tets::WorkingMesh working(grid.mesh, grid.fixed_points);
  tets::ChangeableSurface view = grid.surface.view();
  tets::SurfaceTriangles triangles(view.tri_to_vert, grid.fixed_points);
  tets::SurfaceSlider slider(working, view, triangles, 0.2);
  const std::uint32_t corner = working.corner_of(star[0], vertex);
  CHECK(slider.slide_for_angle(star[0], corner, 1, 1.1) == tets::SlideVerdict::NoGain);
  CHECK(same(grid.mesh, before));
  CHECK(slider.slide_for_angle(star[0], corner, 0, 1.1) == tets::SlideVerdict::Moved);
  CHECK(least_angle_of(grid.mesh, star) > least_angle_of(before, star));
  CHECK(grid.mesh.points[vertex].z == Approx(0.1));
  CHECK(grid.mesh.points[vertex] != before.points[vertex]);
  CHECK(tets::find_fault(grid.mesh) == "");
}

}  // namespace
}  // namespace tetloom
