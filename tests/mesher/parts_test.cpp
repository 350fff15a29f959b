// Volumes filled in parts: as good as in one, and the same for any number of threads.
#include "mesher/intersection/self_intersection.hpp"
#include "mesher/volume/volume_mesher.hpp"
#include "tests/mesher/parts_fixtures.hpp"
#include "tests/support/analytic_model.hpp"
#include "tetloom/tasks.hpp"

using namespace tetloom;
using namespace tetloom::volume_tests;

namespace {

std::uint32_t all_of_it(int, int, int) { return 0; }

Surface ball_in_ball(std::uint32_t core) {
  Surface surface = round_ball(4);
  Surface inner = ball_surface(3, {0.1, 0, 0}, core, [](const Vec3&) { return 0.5; });
  for (FaceSides& sides : inner.tri_to_sides) sides.front = ModelRegionId{0u};
  surface.append(inner);
  return surface;
}

std::vector<PartsCase> all_kinds() {
  std::vector<PartsCase> cases;
  cases.push_back({"uniform", round_ball(4), SizeField::uniform(0.11), 2500});
  cases.push_back({"graded", round_ball(4), growing_sizes(0.06, 0.2), 3e3});
  cases.push_back({"A15", round_ball(4), SizeField::uniform(0.11), 2500, LatticeKind::A15});
  cases.push_back({"graded A15", round_ball(4), growing_sizes(0.07, 0.2), 2500, LatticeKind::A15});
  cases.push_back({"regions", voxel_surface({3, 2, 1}, 8, [](int i, int, int) { return i == 0 ? 4u : 2u; }),
                   SizeField::uniform(1.0 / 8), 2500});
  cases.push_back({"void", ball_in_ball(kOutside), SizeField::uniform(0.11), 2e3});
  cases.push_back({"region in another", ball_in_ball(7), SizeField::uniform(0.11), 2500});
  cases.push_back({"plate", voxel_surface({20, 20, 2}, 1, all_of_it), SizeField::uniform(1), 2e3});
  return cases;
}

void check_whole(const PartsCase& one, const VolumeMesh& mesh, const VolumeMesh& alone) {
  for (const Diagnostic& error : mesh.errors) UNSCOPED_INFO(error.message);
  REQUIRE(mesh.errors.empty());
  INFO(mesh.figures.parts.given_up_why);
  CHECK(mesh.figures.parts.given_up == 0);
  CHECK(mesh.figures.parts.parts >= 3);
  CHECK(mesh.figures.worker_complexes == 0);
  CHECK(alone.figures.parts.parts == 0);
  const auto volumes = check_filling(one.surface, mesh), expected = check_filling(one.surface, alone);
  REQUIRE(volumes.size() == expected.size());
  for (const auto& [region, volume] : expected) CHECK(volumes.at(region) == Approx(volume).epsilon(1e-9));
}

}  // namespace

TEST_CASE("what is filled in parts is valid, and as good as what is filled in one") {
  for (const PartsCase& one : all_kinds()) {
    INFO(one.name);
    const VolumeMesh mesh = fill_case(one), alone = fill_case(one, kOnePart, TaskRunner(2));
    check_whole(one, mesh, alone);
    const Qualities in_parts = qualities_of(one.surface, mesh), in_one = qualities_of(one.surface, alone);
    CHECK(in_parts.mean == Approx(in_one.mean).margin(0.005));
    CHECK(in_parts.low == Approx(in_one.low).margin(0.01));
    CHECK(mesh.figures.optimizer.tets == mesh.tet_to_vert.size());
  }
}

TEST_CASE("parts have together the very tets of the lattice and of the shell that one part has") {
  for (const PartsCase& one : all_kinds()) {
    INFO(one.name);
    const VolumeMesh alone = fill_case(one, kOnePart, TaskRunner(2));
    const VolumeMesh mesh = fill_case(one, 0.6 * one.tets_per_part, TaskRunner(2));
    CHECK(mesh.figures.parts.given_up == 0);
    CHECK(mesh.figures.core_tets == alone.figures.core_tets);
    CHECK(mesh.figures.missing_triangles == alone.figures.missing_triangles);
    const double few = mesh.figures.missing_triangles == 0 ? 0 : 0.005;  // recovery may choose others
    CHECK(double(mesh.figures.shell_tets) == Approx(double(alone.figures.shell_tets)).epsilon(few));
  }
}

TEST_CASE("a mesh made in parts does not depend on the number of threads") {
  std::vector<PartsCase> cases = all_kinds();
  cases.push_back({"prisms", ball_with_prisms(3, {{-0.4, 0, 0}, {0.4, 0.1, 0}}, 0.25), SizeField::uniform(0.12), 1500});
  for (const PartsCase& one : cases) {
    INFO(one.name);
    const VolumeMesh mesh = fill_case(one, 1);
    for (const int threads : {2, 4, 8}) CHECK(same_mesh(fill_case(one, threads), mesh));
  }
}

TEST_CASE("what lies between parts becomes less from round to round") {
  for (const PartsCase& one : all_kinds()) {
    INFO(one.name);
    const auto strips = fill_case(one).figures.parts.strips;
    CHECK(strips[0].waiting > 0);
    CHECK(strips[0].moved > 0);
    for (std::size_t round = 0; round < strips.size(); ++round) {
      CHECK(strips[round].moved <= strips[round].tets);
      if (round == 0) continue;
      CHECK(2 * strips[round].waiting < strips[round - 1].waiting);
      CHECK(strips[round].tets <= strips[round - 1].tets);
    }
  }
}

TEST_CASE("triangles that are missing between parts are recovered") {
  const std::vector<Vec3> centers{{-0.5, 0, 0}, {0.5, 0.05, 0}, {0, 0.45, 0.3}, {0, -0.5, -0.2}};
  std::vector<PartsCase> cases;
  cases.push_back({"small", ball_with_prisms(3, centers, 0.12), SizeField::uniform(0.12), 1e3});
  cases.push_back({"large", ball_with_prisms(3, centers, 0.25), SizeField::uniform(0.12), 1e3});
  cases.push_back({"graded", ball_with_prisms(3, centers, 0.2), growing_sizes(0.08, 0.2), 1e3});
  for (const PartsCase& one : cases) {
    INFO(one.name);
    const VolumeMesh mesh = fill_case(one);
    CHECK(mesh.figures.missing_triangles > 0);
    check_whole(one, mesh, fill_case(one, kOnePart, TaskRunner(2)));
  }
}

// Two rough balls, one in the other, nearer to each other than their triangles are wide.
TEST_CASE("parts mend thousands of missing triangles of a thin wall") {
  std::mt19937 random(5);
  const auto rough = [&](double radius) {
    return ball_surface(6, {0, 0, 0}, 0,
                        [&, radius](const Vec3&) { return radius + 8e-4 * double(random()) * 0x1p-32; });
  };
  PartsCase one{"thin", rough(1), SizeField::uniform(0.05), 4e3};
  Surface hole = rough(0.999);
  for (Vec3& p : hole.points) p = {0.96 * p.x - 0.28 * p.y, 0.28 * p.x + 0.96 * p.y, p.z};
  for (auto& triangle : hole.tri_to_vert) std::swap(triangle[1], triangle[2]);
  one.surface.append(hole);
  const VolumeMesh mesh = fill_case(one);
  CHECK(mesh.figures.missing_triangles > 3000);
  check_whole(one, mesh, fill_case(one, kOnePart, TaskRunner(2)));
}

TEST_CASE("where sizes change as fast as they may, tets that a part cannot know are found by asking") {
  struct Small {
    double finest, shift, tets_per_part;
  };
  for (const auto& [finest, shift, tets_per_part] :
       {Small{0.025, -0.95, 100}, {0.025, -0.95, 140}, {0.03, -0.95, 120}, {0.03, -1, 150}, {0.03, -1, 240}}) {
    CAPTURE(finest, shift, tets_per_part);
    PartsCase one{"steep", round_ball(4), growing_sizes(finest, 0.9), tets_per_part};
    for (Vec3& x : one.surface.points) x = 0.5 * x + Vec3{shift, 0, 0};
    const VolumeMesh mesh = fill_case(one);
    CHECK(mesh.figures.parts.asking_rounds < 8);
    check_whole(one, mesh, fill_case(one, kOnePart, TaskRunner(2)));
  }
}

TEST_CASE("random star-shaped bodies are filled in parts, where tets reach far and sizes do not fit the surface") {
  const unsigned seed = 1234;
  CAPTURE(seed);
  std::mt19937_64 random(seed);
  std::size_t missing = 0, in_parts = 0;
  for (int body = 0; body < 24; ++body) {
    CAPTURE(body);
    std::uniform_real_distribution<double> radius(body % 2 == 0 ? 0.8 : 0.4, 1);
    const Surface surface = ball_surface(2 + body % 3, {}, 0, [&](const Vec3&) { return radius(random); });
    const PartsCase one{"body", surface, body % 4 < 2 ? SizeField::uniform(0.2) : growing_sizes(0.12, 0.3), 500};
    const VolumeMesh mesh = fill_case(one);
    for (const Diagnostic& error : mesh.errors) UNSCOPED_INFO(error.message);
    REQUIRE(mesh.errors.empty());
    INFO(mesh.figures.parts.given_up_why);
    CHECK(mesh.figures.parts.given_up == 0);
    missing += mesh.figures.missing_triangles, in_parts += mesh.figures.parts.parts > 1;
    double expected = 0;
    for (const auto& [a, b, c] : surface.tri_to_vert)
      expected += dot(surface.points[a], cross(surface.points[b], surface.points[c])) / 6;
    CHECK(check_filling(surface, mesh).at(0) == Approx(expected).epsilon(1e-9));
  }
  CHECK(missing > 100);
  CHECK(in_parts == 24);
}

TEST_CASE("the surface of a volume in parts may change, and is true to the model") {
  PartsCase one{"shaken", round_ball(4), SizeField::uniform(0.1), 8e3};
  std::mt19937 random(5);
  const auto amount = [&] { return 0.06 * (double(random()) / 4294967296.0 - 0.5); };
  for (Vec3& x : one.surface.points) x = normalized(x + Vec3{amount(), amount(), amount()});
  const auto model = test_models::make_sphere({}, 1);
  const std::vector<ModelEntity> point_to_entity(one.surface.points.size(), ModelFaceId(0));
  const auto fill = [&](bool improve, int threads) {
    VolumeInput input = one.surface.input(one.sizes);
    input.model = model.get(), input.point_to_entity = point_to_entity;
    VolumeOptions options;
    options.improve_surface = improve, options.tets_per_part = one.tets_per_part;
    return fill_volume(input, options, TaskRunner(threads));
  };
  const VolumeMesh mesh = fill(true, 2), kept = fill(false, 2);
  CAPTURE(kept.figures.optimizer.below_dihedral, kept.figures.optimizer.least, kept.figures.parts.parts);
  for (const Diagnostic& error : mesh.errors) UNSCOPED_INFO(error.message);
  REQUIRE(mesh.errors.empty());
  INFO(mesh.figures.parts.given_up_why);
  CHECK(mesh.figures.parts.given_up == 0);
  CHECK(mesh.figures.parts.parts > 2);
  CHECK(mesh.moved_points.size() + mesh.changed_triangles.size() > 0);
  CHECK(kept.moved_points.size() + kept.changed_triangles.size() == 0);
  Surface changed = one.surface;
  for (const MovedPoint& moved : mesh.moved_points) {
    changed.points[moved.point] = moved.to;
    CHECK(norm(moved.to) == Approx(1).epsilon(1e-12));
  }
  for (const ChangedTriangle& triangle : mesh.changed_triangles)
    changed.tri_to_vert[triangle.triangle] = triangle.verts;
  CHECK(check_filling(changed, mesh).at(0) == Approx(4.18).epsilon(0.03));
  CHECK(find_self_intersections({changed.points, changed.tri_to_vert, {}}, TaskRunner(1)).empty());
  CHECK(mesh.figures.optimizer.below_dihedral <= kept.figures.optimizer.below_dihedral);
  const VolumeMesh again = fill(true, 1);
  CHECK(same_mesh(again, mesh));
  REQUIRE(again.moved_points.size() == mesh.moved_points.size());
  for (std::size_t i = 0; i < mesh.moved_points.size(); ++i) CHECK(again.moved_points[i].to == mesh.moved_points[i].to);
}
