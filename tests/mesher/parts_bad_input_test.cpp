// Input and options that filling in parts has to refuse, or that leave parts nearly empty.
#include "mesher/volume/volume_mesher.hpp"
#include "tests/mesher/parts_fixtures.hpp"
#include "tests/support/error_of.hpp"
#include "tetloom/tasks.hpp"

using namespace tetloom;
using namespace tetloom::volume_tests;
using test::error_of;

namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

// Errors in parts are those in one.
void check_same_errors(const PartsCase& one, ErrorCode code) {
  const VolumeMesh mesh = fill_case(one), alone = fill_case(one, kOnePart, TaskRunner(2));
  CHECK(mesh.tet_to_vert.empty());
  REQUIRE(!alone.errors.empty());
  CHECK(alone.errors[0].code == code);
  REQUIRE(mesh.errors.size() == alone.errors.size());
  for (std::size_t i = 0; i < mesh.errors.size(); ++i) {
    CHECK(mesh.errors[i].code == alone.errors[i].code);
    CHECK(mesh.errors[i].message == alone.errors[i].message);
    CHECK(mesh.errors[i].point == alone.errors[i].point);
    CHECK(mesh.errors[i].elements == alone.errors[i].elements);
  }
}

Surface moved(Surface surface, const Vec3& by) {
  for (Vec3& x : surface.points) x += by;
  return surface;
}

}  // namespace

TEST_CASE("a number of tets per part that is negative or none is refused") {
  const PartsCase one{"ball", round_ball(2), SizeField::uniform(0.3), 0};
  for (const double tets : {-1.0, -1e-300, -HUGE_VAL, kNan})
    CHECK(error_of([&] { fill_case(one, tets, TaskRunner(1)); }).code == ErrorCode::InvalidArgument);
}

TEST_CASE("what is small for two parts is filled in one, and so is everything when parts have no end") {
  const PartsCase one{"ball", round_ball(3), SizeField::uniform(0.15), 0};
  const VolumeMesh mesh = fill_case(one, kOnePart, TaskRunner(1));
  for (const double tets : {0.0, 1e5, 1e300}) {
    const VolumeMesh other = fill_case(one, tets, TaskRunner(2));
    CHECK(other.figures.parts.parts == 0);
    CHECK(same_mesh(other, mesh));
  }
}

TEST_CASE("parts of a few tets, and more parts than points, make a valid mesh") {
  const PartsCase one{"ball", round_ball(3), SizeField::uniform(0.25), 0};
  for (const double tets : {100.0, 20.0, 8.0}) {
    CAPTURE(tets);
    const VolumeMesh mesh = fill_case(one, tets, TaskRunner(2));
    REQUIRE(mesh.errors.empty());
    INFO(mesh.figures.parts.given_up_why);
    CHECK(mesh.figures.parts.given_up == 0);
    CHECK(mesh.figures.parts.parts > 10);
    CHECK(check_filling(one.surface, mesh).at(0) == Approx(4.1).epsilon(0.03));
    CHECK(same_mesh(mesh, fill_case(one, tets, TaskRunner(1))));
  }
}

TEST_CASE("a surface without room for the points of a lattice is filled in parts") {
  const PartsCase one{"rod", voxel_surface({250, 1, 1}, 1, [](int, int, int) { return 0u; }), SizeField::uniform(2),
                      60};
  const VolumeMesh mesh = fill_case(one);
  REQUIRE(mesh.errors.empty());
  INFO(mesh.figures.parts.given_up_why);
  CHECK(mesh.figures.parts.given_up == 0);
  CHECK(mesh.figures.parts.parts > 3);
  CHECK(mesh.new_points.size() < 60);
  CHECK(check_filling(one.surface, mesh).at(0) == Approx(250));
}

TEST_CASE("two points in one place are the error in parts that they are in one") {
  Surface shells = cube_surface(8);
  shells.append(moved(cube_surface(8), {1, 1, 1}));
  check_same_errors({"shells", shells, SizeField::uniform(1.0 / 8), 2e3}, ErrorCode::SelfIntersection);
}

TEST_CASE("a surface that crosses itself is the error in parts that it is in one") {
  Surface crossing = cube_surface(8);
  crossing.append(ball_surface(3, {0.5, 0.5, 0.9}, 0, [](const Vec3&) { return 0.3; }));
  check_same_errors({"crossing", crossing, SizeField::uniform(1.0 / 8), 2e3}, ErrorCode::SelfIntersection);
  Surface inverted = round_ball(4);
  for (FaceSides& sides : inverted.tri_to_sides) std::swap(sides.front, sides.back);
  check_same_errors({"inside out", inverted, SizeField::uniform(0.1), 2e3}, ErrorCode::VolumeFailed);
}

TEST_CASE("where one of two complexes cannot be filled, the other is filled in parts") {
  Surface surface = round_ball(4);
  Surface open = moved(voxel_surface({1, 1, 1}, 8, [](int, int, int) { return 1u; }), {5, 0, 0});
  open.tri_to_vert.pop_back(), open.tri_to_sides.pop_back(), open.tri_to_face.pop_back();
  surface.append(open);
  const PartsCase one{"two", surface, SizeField::uniform(0.1), 4e3};
  const VolumeMesh mesh = fill_case(one);
  REQUIRE(mesh.errors.size() == 1);
  CHECK(mesh.errors[0].code == ErrorCode::OpenShell);
  CHECK(mesh.figures.parts.parts > 2);
  CHECK(check_filling(surface, mesh, {1}).at(0) == Approx(4.17).epsilon(0.01));
}

TEST_CASE("parts far from the origin, and of any scale, are filled alike") {
  const PartsCase one{"ball", round_ball(3), SizeField::uniform(0.15), 1e3};
  const VolumeMesh mesh = fill_case(one);
  CHECK(mesh.figures.parts.parts > 3);
  for (const double scale : {0x1p-100, 0x1p100}) {
    const PartsCase other{"scaled", scaled(one.surface, scale), SizeField::uniform(0.15 * scale), 1e3};
    const VolumeMesh again = fill_case(other);
    CHECK((again.tet_to_vert == mesh.tet_to_vert));
    REQUIRE(again.new_points.size() == mesh.new_points.size());
    for (std::size_t i = 0; i < mesh.new_points.size(); ++i) REQUIRE(again.new_points[i] == scale * mesh.new_points[i]);
  }
  const PartsCase far{"far", moved(one.surface, {1e6, -1e6, 1e6}), one.sizes, 1e3};
  const VolumeMesh there = fill_case(far);
  REQUIRE(there.errors.empty());
  CHECK(there.figures.parts.given_up == 0);
  CHECK(check_filling(far.surface, there).at(0) == Approx(check_filling(one.surface, mesh).at(0)).epsilon(1e-6));
}
