// Surfaces that bound no volume: what is said of them, and what is filled all the same.
#include "mesher/volume/volume_mesher.hpp"
#include "tests/mesher/filled_surface.hpp"
#include "tetloom/tasks.hpp"

using namespace tetloom;
using namespace tetloom::volume_tests;

TEST_CASE("an open shell is named with its faces and a point, and the other regions are filled") {
  Surface surface = cube_surface(3);
  Surface open = voxel_surface({1, 1, 1}, 2, [](int, int, int) { return 1u; });
  for (Vec3& p : open.points) p.x += 1.5;
  open.tri_to_vert.pop_back(), open.tri_to_sides.pop_back(), open.tri_to_face.pop_back();
  surface.append(open);
  const VolumeMesh mesh = fill(surface, 0.4);
  REQUIRE(mesh.errors.size() == 1);
  CHECK(mesh.errors[0].code == ErrorCode::OpenShell);
  REQUIRE(mesh.errors[0].entities.size() >= 2);
  CHECK(mesh.errors[0].entities.front().entity.dim == 2);
  CHECK(mesh.errors[0].entities.back().entity == ModelEntity(3, 1));
  REQUIRE(mesh.errors[0].point);
  CHECK(mesh.errors[0].point->x > 1.4);
  CHECK(mesh.errors[0].elements.size() >= 3);
  CHECK(check_filling(surface, mesh, {1}).at(0) == Approx(1));
}

TEST_CASE("an open region leaves its neighbour's common faces in place") {
  Surface pair = voxel_surface({2, 1, 1}, 3, [](int i, int, int) { return static_cast<std::uint32_t>(i); });
  const auto is_outer = [&](std::size_t t) {
    return pair.tri_to_sides[t].back == ModelRegionId{1u} && !pair.tri_to_sides[t].front.valid();
  };
  std::size_t hole = 0;
  while (!is_outer(hole)) ++hole;
  const auto erase = [&](auto& list) { list.erase(list.begin() + static_cast<std::ptrdiff_t>(hole)); };
  erase(pair.tri_to_vert), erase(pair.tri_to_sides), erase(pair.tri_to_face);
  const VolumeMesh mesh = fill(pair, 0.4);
  REQUIRE(mesh.errors.size() == 1);
  CHECK(check_filling(pair, mesh, {1}).at(0) == Approx(1));
}

TEST_CASE("a surface that crosses itself is an error with faces, triangles and a point") {
  Surface surface = cube_surface(2);
  Surface inner = ball_surface(2, {0.5, 0.5, 0.9}, 0, [](const Vec3&) { return 0.3; });
  for (std::uint32_t& face : inner.tri_to_face) face = 9;
  surface.append(inner);  // a second shell of the same region, through the cube's top
  const VolumeMesh mesh = fill(surface, 0.5);
  REQUIRE(!mesh.errors.empty());
  CHECK(mesh.errors[0].code == ErrorCode::SelfIntersection);
  REQUIRE(mesh.errors[0].entities.size() >= 2);
  CHECK(mesh.errors[0].entities[1].entity == ModelEntity(2, 9));
  REQUIRE(mesh.errors[0].point);
  CHECK(mesh.errors[0].point->z == Approx(1));
  CHECK(!mesh.errors[0].elements.empty());
  CHECK(mesh.tet_to_vert.empty());
}

TEST_CASE("sides that contradict each other are an error, not a mesh") {
  Surface surface = cube_surface(2);  // inside out
  for (FaceSides& sides : surface.tri_to_sides) std::swap(sides.front, sides.back);
  const VolumeMesh mesh = fill(surface, 0.5);
  REQUIRE(mesh.errors.size() == 1);
  CHECK(mesh.tet_to_vert.empty());
}

TEST_CASE("input that breaks the contract is refused") {
  const SizeField sizes = SizeField::uniform(1);
  Surface bad_index = cube_surface(1);
  bad_index.tri_to_vert[3][1] = 99;
  CHECK_THROWS_AS(fill_volume(bad_index.input(sizes), {}, TaskRunner(1)), Error);
  Surface bad_point = cube_surface(1);
  bad_point.points[2].y = std::nan("");
  CHECK_THROWS_AS(fill_volume(bad_point.input(sizes), {}, TaskRunner(1)), Error);
  Surface bad_length = cube_surface(1);
  bad_length.tri_to_face.pop_back();
  CHECK_THROWS_AS(fill_volume(bad_length.input(sizes), {}, TaskRunner(1)), Error);
  VolumeInput no_sizes = cube_surface(1).input(sizes);
  no_sizes.sizes = nullptr;
  CHECK_THROWS_AS(fill_volume(no_sizes, {}, TaskRunner(1)), Error);
}

TEST_CASE("no surface gives an empty mesh") {
  const VolumeMesh mesh = fill(Surface{}, 1);
  CHECK(mesh.tet_to_vert.empty());
  CHECK(mesh.errors.empty());
}
