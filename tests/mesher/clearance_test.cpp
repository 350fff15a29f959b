// Boundary layers: how far away opposite walls are.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>

#include "mesher/layers/clearance.hpp"
#include "tests/mesher/layers_fixture.hpp"

using namespace tetloom;
using namespace tetloom::layers;
using namespace tetloom::test_layers;
using namespace tetloom::test_models;

TEST_CASE("opposite walls are as far away for many curves together as for each of them alone") {
  const auto plate = make_box({0, 0, 0}, {3, 2, 1});
  MeshOptions options = options_of_size(0.3);
  options.surface_only = true;
  const Mesh mesh = meshed(*plate, options).mesh;
  const TaskRunner runner(2, {});
  const intersection::TriangleTree tree(mesh.points, mesh.tri_to_vert, runner);
  std::vector<FaceSides> sides;
  for (const std::uint32_t face : mesh.tri_to_entity) sides.push_back(plate->topology().face_to_sides[face]);
  const std::vector<std::uint8_t> has_layers(2 * sides.size(), 1);
  std::vector<LookAhead> looks;
  for (const Vec3& x : mesh.points) {
    const Vec3 in = Vec3{1.5, 1, 0.5} - x;
    for (const Vec3& direction : {in, Vec3{in.x, 0, in.z}, Vec3{0, 0, in.z}})
      looks.push_back({0, x, normalized(direction), 1.2});
    looks.push_back({7, x, normalized(in), 1.2});  // of another region
  }
  const auto has_foot = [&](std::size_t look, std::uint32_t triangle) {
    return std::ranges::count(mesh.tri_to_vert[triangle], static_cast<std::uint32_t>(look / 4)) > 0;
  };
  const std::vector<Clearance> together = find_clearances({sides, has_layers, tree, has_foot}, looks, runner);
  std::size_t met = 0;
  for (std::size_t i = 0; i < looks.size(); ++i) {
    const auto has_its_foot = [&](std::size_t, std::uint32_t triangle) { return has_foot(i, triangle); };
    const auto alone = find_clearances({sides, has_layers, tree, has_its_foot}, std::span(looks).subspan(i, 1), runner);
    REQUIRE(together[i].distance == alone[0].distance);
    met += together[i].distance < HUGE_VAL;
    const bool goes_through = i % 4 == 2 && looks[i].direction != Vec3{};  // from the floor to the ceiling, or back
    if (goes_through && (looks[i].point.z == 0 || looks[i].point.z == 1)) CHECK(together[i].distance == Approx(1));
    if (i % 4 == 3) CHECK(together[i].distance == HUGE_VAL);
  }
  CHECK(met > looks.size() / 4);
}
