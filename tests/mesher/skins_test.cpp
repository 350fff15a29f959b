// Where walls of a region face each other with nothing between them.
#include <array>
#include <catch2/catch.hpp>
#include <vector>

#include "mesher/intersection/skins.hpp"
#include "tetloom/tasks.hpp"

using namespace tetloom;

namespace {

constexpr std::array kTolerances{1e-7, 1e-7};

/// Two triangles, one `gap` above the other, of face 0 and face 1; the region lies between them, or on both other
/// sides. Each is turned so that its normal points up where `up` says so.
Mesh two_walls(double gap, bool between, const std::array<bool, 2>& up) {
  Mesh mesh;
  for (const double z : {0.0, gap})
    for (const Vec3& x : {Vec3{0, 0, z}, Vec3{1, 0, z}, Vec3{0, 1, z}}) mesh.points.push_back(x);
  for (std::uint32_t i = 0; i < 2; ++i) {
    const std::uint32_t a = 3 * i;
    mesh.tri_to_vert.push_back(up[i] ? std::array{a, a + 1, a + 2} : std::array{a, a + 2, a + 1});
    mesh.tri_to_entity.push_back(i);
    const bool region_above = (i == 0) == between;
    FaceSides sides;
    (region_above == up[i] ? sides.front : sides.back) = ModelRegionId(0);
    mesh.face_to_sides.push_back(sides);
  }
  return mesh;
}

std::vector<TriangleIntersection> skins_of(const Mesh& mesh, std::span<const double> tolerances = kTolerances) {
  const TaskRunner runner(1);
  const intersection::TriangleTree tree(mesh.points, mesh.tri_to_vert, runner);
  return find_skins(mesh, tolerances, tree, SharedWork(runner));
}

}  // namespace

TEST_CASE("walls with a region of no thickness between them are a skin, however they are turned") {
  for (const std::array up : {std::array{false, false}, {false, true}, {true, false}, {true, true}}) {
    for (const double gap : {8e-15, 1e-9, 0.9e-7}) {
      const std::vector<TriangleIntersection> found = skins_of(two_walls(gap, true, up));
      REQUIRE(found.size() == 1);
      CHECK(found[0].first == 0);
      CHECK(found[0].second == 1);
      CHECK(found[0].kind == IntersectionKind::Skin);
      CHECK(distance(found[0].point, {1.0 / 3, 1.0 / 3, 0}) < 1e-6);
      CHECK(skins_of(two_walls(gap, false, up)).empty());  // a crack
    }
    CHECK(skins_of(two_walls(2e-7, true, up)).empty());
    CHECK(skins_of(two_walls(0, true, up)).empty());  // left to the exact test
  }
}

TEST_CASE("of two faces the larger tolerance counts") {
  const Mesh mesh = two_walls(1e-5, true, {false, true});
  CHECK(skins_of(mesh).empty());
  CHECK(skins_of(mesh, std::array{1e-7, 2e-5}).size() == 1);
  CHECK(skins_of(mesh, std::array{2e-5, 1e-7}).size() == 1);
}

TEST_CASE("walls beside each other, of different regions, or with a common vertex are no skin") {
  Mesh beside = two_walls(1e-9, true, {false, true});
  for (std::size_t v = 3; v < 6; ++v) beside.points[v] += Vec3{0.8, 0.8, 0};
  CHECK(skins_of(beside).empty());
  Mesh others = two_walls(1e-9, true, {false, true});
  for (ModelRegionId* side : {&others.face_to_sides[1].front, &others.face_to_sides[1].back})
    if (side->valid()) *side = ModelRegionId(1);
  CHECK(skins_of(others).empty());
  Mesh wedge = two_walls(1e-9, true, {false, true});
  for (std::uint32_t& v : wedge.tri_to_vert[1])
    if (v == 3) v = 0;
  CHECK(skins_of(wedge).empty());
}
