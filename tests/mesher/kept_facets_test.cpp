// Surfaces of facets that stay as given where remeshed ones would cross.
#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <map>
#include <set>

#include "mesher/surface/kept_facets.hpp"
#include "mesher/surface/surface_mesher.hpp"
#include "tests/core/discrete_shapes.hpp"
#include "tetloom/model.hpp"
#include "tetloom/tasks.hpp"

using namespace tetloom;

namespace {

using Place = std::array<double, 3>;

std::array<Place, 3> places_of(std::span<const Vec3> points, const std::array<std::uint32_t, 3>& verts) {
  std::array<Place, 3> places;
  for (std::size_t i = 0; i < 3; ++i) places[i] = {points[verts[i]].x, points[verts[i]].y, points[verts[i]].z};
  std::ranges::rotate(places, std::ranges::min_element(places));
  return places;
}

bool is_closed(const Mesh& mesh) {
  std::map<std::array<std::uint32_t, 2>, int> sides;
  for (const auto& verts : mesh.tri_to_vert)
    for (std::size_t i = 0; i < 3; ++i) ++sides[{verts[i], verts[(i + 1) % 3]}];
  return std::ranges::all_of(sides, [&](const auto& side) {
    const auto back = sides.find({side.first[1], side.first[0]});
    return side.second == 1 && back != sides.end();
  });
}

/// How many facets inside of a ball are triangles of the mesh, and how many there are.
std::array<std::size_t, 2> count_kept(const shapes::Facets& facets, const KeptPlace& ball, const Mesh& mesh) {
  std::set<std::array<Place, 3>> triangles;
  for (const auto& verts : mesh.tri_to_vert) triangles.insert(places_of(mesh.points, verts));
  std::array<std::size_t, 2> counts{};
  for (const auto& verts : facets.triangles) {
    if (std::ranges::any_of(verts, [&](auto v) { return distance(facets.points[v], ball.center) > ball.radius; }))
      continue;
    ++counts[1];
    counts[0] += triangles.count(places_of(facets.points, verts));
  }
  return counts;
}

}  // namespace

TEST_CASE("facets stay as they are in a ball, inside of a face and across an edge, and the surface stays closed") {
  const bool across_edge = GENERATE(false, true);
  const shapes::Facets facets =
      across_edge ? shapes::make_cylinder(1, 3, 100, 30) : shapes::make_sphere({0, 0, 0}, 1, 4);
  const KeptPlace ball{across_edge ? Vec3{1, 0, 3} : Vec3{1, 0, 0}, 0.45};
  const auto model = make_discrete_model(facets.points, facets.triangles, 0.7);
  const TaskRunner runner(2);
  const SizeField sizes = SizeField::uniform(0.5);
  SurfaceMesher mesher(*model, runner);
  const Mesh before = mesher.mesh(sizes).mesh;
  REQUIRE(count_kept(facets, ball, before)[0] == 0);
  REQUIRE(mesher.keep_facets(std::array{ball}));
  CHECK_FALSE(mesher.keep_facets(std::array{ball}));
  const Mesh after = mesher.mesh(sizes).mesh;
  const auto [kept, inside] = count_kept(facets, ball, after);
  CHECK(inside > 50);
  CHECK(kept == inside);
  CHECK(is_closed(after));
  CHECK(after.tri_to_vert.size() < facets.triangles.size());
}

TEST_CASE("a ball is kept once") {
  KeptFacets kept;
  CHECK(kept.empty());
  CHECK_FALSE(kept.holds({0, 0, 0}));
  CHECK(kept.add({{0, 0, 0}, 1}));
  CHECK_FALSE(kept.add({{0.4, 0, 0}, 1}));
  CHECK_FALSE(kept.add({{0.4, 0, 0}, 0.5}));
  CHECK(kept.add({{0.4, 0, 0}, 2}));
  CHECK(kept.add({{5, 0, 0}, 1}));
  CHECK(kept.holds({5.5, 0, 0}));
  CHECK_FALSE(kept.holds({3.5, 0, 0}));
}
