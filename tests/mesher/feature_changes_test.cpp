// Small features: single changes on a few triangles, and merges of many.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <map>
#include <numbers>
#include <random>

#include "mesher/features/cone.hpp"
#include "mesher/features/displacement.hpp"
#include "mesher/features/eliminate_features.hpp"
#include "mesher/features/local_change.hpp"
#include "mesher/features/shape_check.hpp"
#include "tests/support/analytic_shapes.hpp"
#include "tests/support/strip_mesh.hpp"
#include "tetloom/tasks.hpp"

using namespace tetloom;
using namespace tetloom::features;
using namespace tetloom::test_models;

namespace {

double area_of(const Mesh& mesh) {
  double area = 0;
  for (const auto& [a, b, c] : mesh.tri_to_vert)
    area += 0.5 * norm(cross(mesh.points[b] - mesh.points[a], mesh.points[c] - mesh.points[a]));
  return area;
}

long euler_characteristic(const Mesh& mesh) {
  std::map<std::array<std::uint32_t, 2>, int> edges;
  std::vector<std::uint8_t> used(mesh.points.size(), 0);
  for (const auto& tri : mesh.tri_to_vert)
    for (std::size_t i = 0; i < 3; ++i) {
      used[tri[i]] = 1;
      ++edges[{std::min(tri[i], tri[(i + 1) % 3]), std::max(tri[i], tri[(i + 1) % 3])}];
    }
  return std::count(used.begin(), used.end(), 1) - static_cast<long>(edges.size()) +
         static_cast<long>(mesh.tri_to_vert.size());
}

SurfaceComplex surface_of(const Mesh& mesh) {
  static std::vector<FaceSides> sides;
  sides = mesh.face_to_sides;
  return {
      {mesh.points, mesh.point_to_entity, mesh.tri_to_vert, mesh.tri_to_entity, mesh.edge_to_vert, mesh.edge_to_entity},
      sides};
}

EliminationResult eliminate(const Mesh& mesh, double tolerance, std::span<const KeptPlace> kept = {}) {
  const std::vector<double> tolerances(mesh.points.size(), tolerance), sizes(mesh.points.size(), 1.0);
  return eliminate_small_features(mesh, {tolerances, sizes, kept}, TaskRunner(1));
}

}  // namespace

TEST_CASE("cones side by side in a plane are apart, however narrow, and those upon each other are not") {
  const double limit = 15 * kDegree;
  const auto at = [](double degrees, double height) {
    return Vec3{std::cos(degrees * kDegree), std::sin(degrees * kDegree), height};
  };
  for (const double width : {0.1, 1.0, 10.0, 80.0}) {
    const Cone first = make_cone({0, 0, 0}, at(0, 0), at(width, 0));
    const Cone beside = make_cone({0, 0, 0}, at(width, 0), at(width + 60, 0));
    CHECK(separation(first, beside, limit) > 1);
  }
  const Cone wide = make_cone({0, 0, 0}, at(0, 0), at(60, 0));
  const Cone above = make_cone({0, 0, 0}, at(5, 0.1), at(70, 0.1));
  CHECK(separation(wide, above, limit) < 1);
  const Cone far_above = make_cone({0, 0, 0}, at(5, 0.6), at(70, 0.6));
  CHECK(separation(wide, far_above, limit) > 1);
  // Common side, at a small dihedral angle.
  const Cone leaf = make_cone({0, 0, 0}, at(0, 0), at(60, 0.15));
  CHECK(separation(wide, leaf, limit) < 1);
  CHECK(separation(wide, make_cone({0, 0, 0}, {1, 0, 0}, {2, 0, 0}), limit) == HUGE_VAL);
}

TEST_CASE("a collapse keeps the topology and the classification") {
  const SurfaceComplex plain = surface_of(make_strip(false));
  CHECK(plan_collapse(plain, 5, 6));
  // Both ends on the rim, the edge across: the sheet would be pinched.
  CHECK_FALSE(plan_collapse(plain, 1, 9));
  CHECK_FALSE(plan_collapse(plain, 4, 9));
  const SurfaceComplex with_edge = surface_of(make_strip(true));
  CHECK(plan_collapse(with_edge, 5, 6));
  CHECK(plan_collapse(with_edge, 5, 1));
  const SurfaceComplex inner = surface_of(make_strip(false));
  // A point of a model edge does not move into a face.
  CHECK_FALSE(plan_collapse(inner, 1, 5));
}

TEST_CASE("a collapse whose link is a triangle without triangle is refused") {
  // An open tetrahedron on a triangle that is not there: 0 and 1 have the common neighbours 2 and 3, but 0 1 3 is no
  // triangle.
  Mesh mesh;
  mesh.points = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {2, 2, 2}};
  mesh.point_to_entity.assign(5, ModelFaceId(0));
  mesh.tri_to_vert = {{0, 1, 2}, {0, 2, 3}, {1, 3, 2}, {1, 4, 3}, {0, 3, 4}, {0, 4, 1}};
  mesh.tri_to_entity.assign(6, 0);
  mesh.face_to_sides.resize(1);
  const SurfaceComplex surface = surface_of(mesh);
  CHECK_FALSE(plan_collapse(surface, 0, 1));
}

TEST_CASE("a snap inside of a face swaps the edge, and one onto a model edge puts the apex there") {
  SurfaceComplex swapped = surface_of(make_strip(false));
  const std::optional<LocalChange> swap = plan_snap(swapped, 1, 2);  // 0 5 4: apex 4 onto 0 5
  REQUIRE(swap);
  CHECK(swap->added.size() == 2);
  apply(*swap, swapped);
  CHECK(swapped.triangles_of_edge(0, 5).empty());
  CHECK(swapped.triangles_of_edge(4, 1).size() == 2);

  Mesh mesh = make_strip(true);
  mesh.points[9] = {1.5, 1.01, 0};
  mesh.point_to_entity[9] = ModelFaceId(1);
  SurfaceComplex snapped = surface_of(mesh);
  std::uint32_t triangle = kNone;
  for (const std::uint32_t t : snapped.triangles_of_edge(5, 6))
    if (std::ranges::find(snapped.triangle(t), 10U) != snapped.triangle(t).end()) triangle = t;
  REQUIRE(triangle != kNone);
  const auto& verts = snapped.triangle(triangle);
  const auto change = plan_snap(snapped, triangle, static_cast<int>(std::ranges::find(verts, 10U) - verts.begin()));
  REQUIRE(change);
  apply(*change, snapped);
  CHECK(snapped.entity(10) == ModelEntity(ModelEdgeId(1)));  // on an edge already: it stays where it is
  CHECK(snapped.find_piece(5, 6) == kNone);
  CHECK(snapped.find_piece(5, 10) != kNone);
  CHECK(snapped.find_piece(10, 6) != kNone);
}

TEST_CASE("a change that would lay triangles of a region upon each other is refused") {
  // The rim of a plate: top and bottom at a distance of .05, closed by a narrow side.
  Mesh mesh;
  mesh.points = {{0, 0, 0}, {1, 0, 0}, {0, 0, 0.05}, {1, 0, 0.05}, {0.5, 1, 0}, {0.5, 1, 0.05}};
  mesh.point_to_entity.assign(6, ModelEdgeId(0));
  mesh.tri_to_vert = {{0, 1, 3}, {0, 3, 2}, {0, 4, 1}, {2, 3, 5}};
  mesh.tri_to_entity = {0, 0, 1, 2};
  mesh.face_to_sides.assign(3, {{}, ModelRegionId(0)});
  const auto keeps = [&](ModelRegionId region) {
    Mesh copy = mesh;
    copy.face_to_sides.assign(3, {{}, region});
    const SurfaceComplex surface = surface_of(copy);
    LocalChange change;  // 2 goes into 0, as it would in a mesh that has all triangles around
    change.gone = 2, change.kept = 0, change.place = surface.point(0), change.entity = surface.entity(0);
    change.removed = {1, 3};
    change.added = {{{0, 3, 5}, 3}};
    return keeps_shape(surface, change, 0.1);
  };
  CHECK_FALSE(keeps(ModelRegionId(0)));
}

TEST_CASE("displacements are told point by point, and bound those between") {
  const std::vector<Vec3> points{{0, 0, 0}, {1, 0, 0}, {0.5, 0.1, 0}, {0, 0.2, 0}};
  Displacement displacement(points);
  CHECK(displacement.from(0, {0, 0, 3}) == Approx(3));
  displacement.merge(3, 0, points[0]);
  CHECK(displacement.from(0, points[0]) == Approx(0.2));
  CHECK(displacement.from(0, {0, 0.1, 0}) == Approx(0.1));
  CHECK(displacement.from_edge(0, 1, 0.5, {0.5, 0.1, 0}) == Approx(0.1));
  displacement.merge_edge(0, 1, 0.5, 2, points[2]);
  CHECK(displacement.from(2, points[2]) == Approx(0.1));
  displacement.note(1, 0.7);
  CHECK(displacement.from(1, points[1]) == Approx(0.7));
}

TEST_CASE("points near a model edge move onto it, and short edges go") {
  Mesh mesh = make_strip(true);
  mesh.points[5] = {1.98, 1, 0};  // beside 6, on the same model edge
  const double area = area_of(mesh);
  const EliminationResult result = eliminate(mesh, 0.1);
  REQUIRE(result.mesh);
  CHECK(result.collapses + result.snaps > 0);
  CHECK(area_of(*result.mesh) == Approx(area));
  CHECK(euler_characteristic(*result.mesh) == euler_characteristic(mesh));
  for (const auto& [a, b] : result.mesh->edge_to_vert)
    CHECK(distance(result.mesh->points[a], result.mesh->points[b]) > 0.1);
  CHECK(std::ranges::is_sorted(result.changed));
}

TEST_CASE("nothing is eliminated where nothing is small, and nothing in places that are kept") {
  CHECK_FALSE(eliminate(make_strip(true), 0.1).mesh);
  Mesh mesh = make_strip(true);
  mesh.points[5] = {1.98, 1, 0};
  const std::vector<KeptPlace> kept{{{2, 1, 0}, 0.5}};
  const EliminationResult result = eliminate(mesh, 0.1, kept);
  CHECK(result.collapses == 0);
  CHECK(result.snaps == 0);
}

TEST_CASE("random merges keep area, topology and distance") {
  for (unsigned seed = 1; seed <= 40; ++seed) {
    INFO("seed " << seed);
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> shift(-0.45, 0.45);
    Mesh mesh = make_strip(true);
    for (const std::uint32_t v : {5, 6}) mesh.points[v].x += shift(random);
    for (const std::uint32_t v : {1, 2, 9, 10}) mesh.points[v].x += shift(random);
    const double area = area_of(mesh);
    const EliminationResult result = eliminate(mesh, 0.5);
    if (!result.mesh) continue;
    CHECK(area_of(*result.mesh) == Approx(area));
    CHECK(euler_characteristic(*result.mesh) == euler_characteristic(mesh));
    for (const AbsorbedEntity& absorbed : result.absorbed) CHECK(absorbed.distance <= 0.5);
  }
}
