// Small features eliminated from surface meshes: single changes on a few triangles, then whole models.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <map>
#include <numbers>
#include <random>

#include "mesher/features/cone.hpp"
#include "mesher/features/displacement.hpp"
#include "mesher/features/eliminate_features.hpp"
#include "mesher/features/local_change.hpp"
#include "mesher/features/shape_check.hpp"
#include "mesher/features/small_features.hpp"
#include "mesher/intersection/pinched_edges.hpp"
#include "mesher/sizing/refinement_budget.hpp"
#include "tests/support/analytic_model.hpp"
#include "tetloom/check.hpp"
#include "tetloom/mesh.hpp"
#include "tetloom/tasks.hpp"

using namespace tetloom;
using namespace tetloom::features;
using namespace tetloom::test_models;

namespace {

constexpr double kDegree = std::numbers::pi / 180;

/// Two rows of squares, each cut in two, in one face, but for the points, which are as given; the middle row of points
/// (4 … 7) lies on the model edge 0 where `with_edge`.
///
///   8---9--10--11
///   | / | / | / |
///   4---5---6---7
///   | / | / | / |
///   0---1---2---3
Mesh make_strip(bool with_edge) {
  Mesh mesh;
  for (int j = 0; j < 3; ++j)
    for (int i = 0; i < 4; ++i) mesh.points.push_back({double(i), double(j), 0});
  mesh.point_to_entity.assign(12, ModelFaceId(0));
  for (std::uint32_t j = 0; j < 2; ++j)
    for (std::uint32_t i = 0; i < 3; ++i) {
      const std::uint32_t a = 4 * j + i, b = a + 1, c = a + 4, d = c + 1;
      mesh.tri_to_vert.push_back({a, b, d});
      mesh.tri_to_vert.push_back({a, d, c});
      mesh.tri_to_entity.insert(mesh.tri_to_entity.end(), 2, with_edge ? j : 0);
    }
  for (std::uint32_t i = 4; with_edge && i < 7; ++i) {
    mesh.edge_to_vert.push_back({i, i + 1});
    mesh.edge_to_entity.push_back(0);
  }
  for (std::uint32_t i = 4; with_edge && i < 8; ++i) mesh.point_to_entity[i] = ModelEdgeId(0);
  for (const std::uint32_t rim : {0, 1, 2, 3, 8, 9, 10, 11}) mesh.point_to_entity[rim] = ModelEdgeId(1);
  mesh.face_to_sides.resize(2);
  return mesh;
}

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

/// A cube whose edge along y at x = z = 1 is cut off by a face this wide.
std::unique_ptr<GeometricModel> make_chamfered_cube(double width) {
  const double c = 1 - width / std::sqrt(2);
  const std::vector<Vec3> points{{0, 0, 0}, {1, 0, 0}, {1, 0, c}, {c, 0, 1}, {0, 0, 1},
                                 {0, 1, 0}, {1, 1, 0}, {1, 1, c}, {c, 1, 1}, {0, 1, 1}};
  const std::vector<std::vector<std::uint32_t>> faces{{0, 1, 2, 3, 4}, {9, 8, 7, 6, 5}, {0, 5, 6, 1}, {1, 6, 7, 2},
                                                      {2, 7, 8, 3},    {3, 8, 9, 4},    {4, 9, 5, 0}};
  return make_polyhedron(points, faces);
}

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

MeshOptions options_of_size(double size) {
  MeshOptions options;
  options.sizes.size = size;
  options.threads = 2;
  return options;
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

TEST_CASE("faces that meet in an edge of no model edge are found") {
  Mesh mesh = make_strip(true);
  CHECK(find_pinched_edges(mesh).empty());
  // Without its piece, the edge from 4 to 5 is between two faces.
  mesh.edge_to_vert.erase(mesh.edge_to_vert.begin());
  mesh.edge_to_entity.erase(mesh.edge_to_entity.begin());
  const std::vector<TriangleIntersection> found = find_pinched_edges(mesh);
  REQUIRE(found.size() == 1);
  CHECK(mesh.tri_to_entity[found[0].first] != mesh.tri_to_entity[found[0].second]);
  CHECK(distance(found[0].point, {0.5, 1, 0}) < 1e-12);
  // Two strips on each other, between the same points.
  mesh = make_strip(true);
  for (std::size_t t = 0, count = mesh.tri_to_vert.size(); t < count; ++t) {
    const auto [a, b, c] = mesh.tri_to_vert[t];
    mesh.tri_to_vert.push_back({a, c, b});
    mesh.tri_to_entity.push_back(mesh.tri_to_entity[t]);
  }
  CHECK(find_pinched_edges(mesh).size() >= 3);
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
  const auto model = make_box({0, 0, 0}, {12, 10, 0.04});
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
  const double twice = tets(2), eight_times = tets(8), all = tets(HUGE_VAL);
  CHECK(twice > 1.2 * least);
  CHECK(twice < 2.6 * least);
  CHECK(eight_times > 1.5 * twice);
  CHECK(eight_times < 10 * least);
  CHECK(all > 4 * eight_times);
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
