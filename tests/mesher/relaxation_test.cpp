#include "mesher/tets/relaxation.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <numeric>

#include "core/tets/circumsphere.hpp"
#include "mesher/tets/delaunay_flips.hpp"
#include "mesher/tets/optimizer.hpp"
#include "tests/support/tet_fixtures.hpp"
#include "tetloom/error.hpp"
#include "tetloom/tasks.hpp"

namespace tetloom {
namespace {

using namespace tet_tests;
using tets::WorkingMesh;

constexpr double kNoFloor = 0;

std::size_t flip(TetMesh& mesh, double floor = kNoFloor, std::uint32_t first = 0) {
  WorkingMesh working(mesh, 0);
  const std::size_t flips = tets::flip_to_delaunay(working, first, floor, TaskRunner(1));
  working.finish();
  return flips;
}

std::size_t relax(TetMesh& mesh, std::uint32_t fixed_points, const SizeField& sizes, double floor = kNoFloor,
                  std::uint32_t first = 0) {
  WorkingMesh working(mesh, fixed_points);
  const std::size_t moves = tets::relax(working, first, sizes, floor, TaskRunner(1));
  working.finish();
  return moves;
}

// Two tets on the two sides of a triangle, their apices `height` away from it.
TetMesh make_pair_of_tets(double height) {
  return make_tets({{1, 0, 0}, {-0.5, 0.8, 0}, {-0.5, -0.8, 0}, {0, 0, height}, {0, 0, -height}},
                   {{0, 1, 2, 3}, {0, 1, 2, 4}});
}

double mean_quality(const TetMesh& mesh) {
  double sum = 0;
  for (std::uint32_t t = 0; t < mesh.size(); ++t) sum += quality_of(mesh, t);
  return sum / static_cast<double>(mesh.size());
}

// Faces behind which a vertex lies inside of the circumsphere.
std::size_t count_not_delaunay(const TetMesh& mesh) {
  std::size_t count = 0;
  for (const tets::FaceCode face : mesh.faces()) {
    if (!mesh.behind(face).valid()) continue;
    const std::uint32_t t = face.tet();
    const tets::Circumsphere sphere(mesh.point_of(t, 0), mesh.point_of(t, 1), mesh.point_of(t, 2), mesh.point_of(t, 3));
    count += sphere.holds(mesh.points[mesh.apex(mesh.behind(face))], 1e-6);
  }
  return count;
}

// The integral of what is |x|^2 at the vertices and linear in every tet: least for the Delaunay mesh.
double integrate_interpolant(const TetMesh& mesh) {
  double integral = 0;
  for (std::uint32_t t = 0; t < mesh.size(); ++t) {
    const Vec3 &a = mesh.point_of(t, 0), &b = mesh.point_of(t, 1), &c = mesh.point_of(t, 2), &d = mesh.point_of(t, 3);
    integral += dot(cross(b - a, c - a), d - a) / 24 * (norm2(a) + norm2(b) + norm2(c) + norm2(d));
  }
  return integral;
}

// Over the cube [0, width]^3, from `at_zero` at x = 0 to `at_width`.
SizeField graded_field(double width, double at_zero, double at_width) {
  SizeOctree tree;
  tree.width = width;
  tree.domain = {{0, 0, 0}, {width, width, width}};
  tree.size = std::max(at_zero, at_width);
  tree.gradation = std::abs(at_width - at_zero) / width;
  std::vector<std::array<float, 8>> leaf_to_ratios;
  for (std::uint32_t octant = 0; octant < 8; ++octant) {
    tree.cells.push_back(SizeOctree::kLeafBit + octant);
    std::array<float, 8> ratios{};
    for (std::uint32_t corner = 0; corner < 8; ++corner) {
      const double share = 0.5 * ((octant & 1) + (corner & 1));
      ratios[corner] = static_cast<float>((at_zero + share * (at_width - at_zero)) / tree.size);
    }
    leaf_to_ratios.push_back(ratios);
  }
  set_corner_ratios(tree, leaf_to_ratios);
  return SizeField::from_octree(tree);
}

TEST_CASE("the centre of a circumsphere is as far from all vertices, and what lies nearer is inside") {
  const Vec3 a{0.1, 0.2, -0.3}, b{1.2, 0.1, 0}, c{0.3, 1.4, 0.2}, d{0.2, 0.1, 1.1};
  const tets::Circumsphere sphere(a, b, c, d);
  const Vec3 center = sphere.corner + sphere.twice_moment / (2 * sphere.volume);
  const double radius = distance(center, a);
  for (const Vec3& x : {b, c, d}) CHECK(distance(center, x) == Approx(radius));
  const Vec3 direction{0.6, 0, 0.8};
  CHECK(sphere.holds(center + 0.99 * radius * direction, 0));
  CHECK_FALSE(sphere.holds(center + 1.01 * radius * direction, 0));
  CHECK_FALSE(sphere.holds(center + 0.99 * radius * direction, 0.5));
}

TEST_CASE("two tets whose apices are near are exchanged for three") {
  TetMesh mesh = make_pair_of_tets(0.4);
  const auto faces = fixed_faces(mesh);
  const double volume = volume_of_region(mesh, 0);
  CHECK(flip(mesh) == 1);
  CHECK(mesh.size() == 3);
  CHECK(tets::find_fault(mesh) == "");
  CHECK(fixed_faces(mesh) == faces);
  CHECK(volume_of_region(mesh, 0) == Approx(volume));
  CHECK(count_not_delaunay(mesh) == 0);
}

TEST_CASE("three tets around an edge that is long are exchanged for two") {
  TetMesh mesh = make_ring(3, 2);
  const auto faces = fixed_faces(mesh);
  const double volume = volume_of_region(mesh, 0);
  CHECK(flip(mesh) == 1);
  CHECK(mesh.size() == 2);
  CHECK(tets::find_fault(mesh) == "");
  CHECK(fixed_faces(mesh) == faces);
  CHECK(volume_of_region(mesh, 0) == Approx(volume));
}

TEST_CASE("what is Delaunay, has to stay or would become too poor is not exchanged") {
  TetMesh far = make_pair_of_tets(2), fixed = make_pair_of_tets(0.4), near = make_pair_of_tets(0.85);
  TetMesh before = far;
  CHECK(flip(far) == 0);
  CHECK(same(far, before));
  for (const tets::FaceCode face : tets::FaceCode::of(0)) fix_face(fixed, face);
  before = fixed;
  CHECK(flip(fixed) == 0);
  CHECK(same(fixed, before));
  before = near;
  CHECK(flip(near, 1.0) == 0);
  CHECK(same(near, before));
  CHECK(flip(near, 0.1) == 1);
}

TEST_CASE("exchanges bring a mesh nearer to the Delaunay mesh of its vertices") {
  for (unsigned seed = 0; seed < 6; ++seed) {
    ShakenGrid grid = make_shaken_grid(5, 1, 0.5, seed);
    const double before = integrate_interpolant(grid.mesh);
    const double least = least_quality(grid.mesh);
    const auto faces = fixed_faces(grid.mesh);
    CHECK(flip(grid.mesh, tets::cube(0.1)) > 0);
    CHECK(integrate_interpolant(grid.mesh) < before - 0.1);
    CHECK(tets::find_fault(grid.mesh) == "");
    CHECK(least_quality(grid.mesh) >= std::min(0.1, least) * (1 - 1e-6));
    CHECK(fixed_faces(grid.mesh) == faces);
    CHECK(volume_of_region(grid.mesh, 0) == Approx(125).epsilon(1e-12));
  }
}

TEST_CASE("vertices that are spread make tets better, and what must stay is as it was") {
  for (unsigned seed = 0; seed < 12; ++seed) {
    const int regions = seed % 2 == 0 ? 1 : 2;
    ShakenGrid grid = make_shaken_grid(6, regions, 0.5, seed);
    CAPTURE(seed);
    TetMesh mesh = grid.mesh;
    CHECK(relax(mesh, grid.fixed_points, SizeField::uniform(1), tets::cube(0.1)) > 0);
    CHECK(tets::find_fault(mesh) == "");
    CHECK(mean_quality(mesh) > mean_quality(grid.mesh) + 0.02);
    CHECK(least_quality(mesh) >= std::min(0.1, least_quality(grid.mesh)) * (1 - 1e-6));
    CHECK(fixed_faces(mesh) == fixed_faces(grid.mesh));
    for (std::uint32_t v = 0; v < grid.fixed_points; ++v) CHECK(mesh.points[v] == grid.mesh.points[v]);
    for (int r = 0; r < regions; ++r) {
      const auto region = static_cast<std::uint32_t>(r);
      CHECK(volume_of_region(mesh, region) == Approx(volume_of_region(grid.mesh, region)).epsilon(1e-12));
    }
    TetMesh again = grid.mesh;
    relax(again, grid.fixed_points, SizeField::uniform(1), tets::cube(0.1));
    CHECK(same(mesh, again));
  }
}

TEST_CASE("vertices go where sizes are small") {
  const auto mean_x = [](const SizeField& sizes) {
    ShakenGrid grid = make_shaken_grid(6, 1, 0.2, 1);
    relax(grid.mesh, grid.fixed_points, sizes);
    double sum = 0;
    for (std::uint32_t v = grid.fixed_points; v < grid.mesh.points.size(); ++v) sum += grid.mesh.points[v].x;
    return sum / (static_cast<double>(grid.mesh.points.size()) - grid.fixed_points);
  };
  const double even = mean_x(SizeField::uniform(1));
  CHECK(even == Approx(3).margin(0.1));
  CHECK(mean_x(graded_field(6, 0.6, 1.8)) < even - 0.2);
  CHECK(mean_x(graded_field(6, 1.8, 0.6)) > even + 0.2);
}

TEST_CASE("the first tets and their vertices stay") {
  constexpr std::uint32_t kFirst = 200;
  ShakenGrid grid = make_shaken_grid(5, 1, 0.5, 3);
  TetMesh mesh = grid.mesh;
  CHECK(relax(mesh, grid.fixed_points, SizeField::uniform(1), kNoFloor, kFirst) > 0);
  for (std::uint32_t i = 0; i < kFirst * 4; ++i) {
    CHECK(mesh.to_vert[i] == grid.mesh.to_vert[i]);
    CHECK(mesh.points[mesh.to_vert[i]] == grid.mesh.points[mesh.to_vert[i]]);
  }
  CHECK(tets::find_fault(mesh) == "");
  CHECK_FALSE(same(mesh, grid.mesh));
}

TEST_CASE("a mesh whose vertices are all fixed only exchanges tets") {
  ShakenGrid grid = make_shaken_grid(4, 1, 0.5, 5);
  const auto points = grid.mesh.points;
  CHECK(relax(grid.mesh, static_cast<std::uint32_t>(points.size()), SizeField::uniform(1)) == 0);
  CHECK(grid.mesh.points == points);
  CHECK(tets::find_fault(grid.mesh) == "");
}

TEST_CASE("cancelled while vertices are spread, a mesh is whole") {
  ShakenGrid grid = make_shaken_grid(4, 1, 0.5, 3);
  CancelToken token;
  token.cancel();
  WorkingMesh working(grid.mesh, grid.fixed_points);
  CHECK_THROWS_AS(tets::relax(working, 0, SizeField::uniform(1), kNoFloor, TaskRunner(1, Host{{}, &token})), Error);
  CHECK(tets::find_fault(grid.mesh) == "");
}

}  // namespace
}  // namespace tetloom
