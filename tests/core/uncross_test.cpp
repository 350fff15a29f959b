// Closed surfaces of facets that cross themselves, and what they enclose. Judged by winding numbers at random points.
#include "core/discrete/uncross.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <random>
#include <set>
#include <string>

#include "core/discrete/discrete_builder.hpp"
#include "core/discrete/facet_edges.hpp"
#include "core/discrete/facet_piercings.hpp"
#include "tests/core/discrete_shapes.hpp"

using namespace tetloom;
using namespace tetloom::shapes;

namespace {

// A tube along a curve like an 8, whose branches pass through each other where they meet.
Facets make_eight(double radius, std::uint32_t along = 96, std::uint32_t around = 14) {
  return make_grid(around, along, true, [&](std::uint32_t i, std::uint32_t j) {
    const double t = 2 * M_PI * j / along + 0.01, a = 2 * M_PI * i / around;
    const Vec3 tangent = normalized({2 * std::cos(t), 2 * std::cos(2 * t), 0.2 * std::cos(t + 1)});
    const Vec3 side = normalized(cross(tangent, {0, 0, 1})), up = cross(side, tangent);
    const Vec3 middle{2 * std::sin(t), std::sin(2 * t), 0.2 * std::sin(t + 1)};
    return middle + radius * (std::cos(a) * side - std::sin(a) * up);
  });
}

void move_at_random(Facets& facets, double step, std::mt19937& random) {
  std::uniform_real_distribution<double> within(-step, step);
  for (Vec3& p : facets.points) p += Vec3{within(random), within(random), within(random)};
}

Facets weld(const Facets& facets) {
  detail::FacetSoup soup{facets.points, facets.triangles, {}, {}, {}};
  detail::clean_soup(soup, 0, nullptr);
  return {std::move(soup.points), std::move(soup.tri_to_vert), {}};
}

double volume_of(const detail::UncrossedFacets& made) { return shapes::volume_of({made.points, made.tris, {}}); }

// Every edge has two facets, no facets meet elsewhere, and the surface winds once around exactly those points around
// which the given one winds at least once.
void check_union(const Facets& given, const detail::UncrossedFacets& made, std::mt19937& random) {
  const detail::FacetEdges edges = detail::find_edges(made.tris, made.points.size());
  for (std::size_t edge = 0; edge < edges.size(); ++edge) REQUIRE(edges.halves(edge).size() == 2);
  CHECK(detail::find_piercings(made.points, made.tris, edges, nullptr).all.empty());
  REQUIRE(made.tri_to_cut.size() == made.tris.size());
  for (std::size_t t = 0; t < made.tris.size(); ++t) {
    const Vec3 whole = detail::facet_normal(given.points, given.triangles[made.tri_to_cut[t]]);
    CHECK(dot(detail::facet_normal(made.points, made.tris[t]), whole) >= 0);
  }
  Box3 box;
  for (const Vec3& p : given.points) box.add(p);
  std::uniform_real_distribution<double> share(0, 1);
  for (int i = 0; i < 400; ++i) {
    Vec3 x;
    for (int axis = 0; axis < 3; ++axis) x[axis] = box.lo[axis] + share(random) * (box.hi[axis] - box.lo[axis]);
    const double before = detail::winding_number(given.points, given.triangles, x);
    const double after = detail::winding_number(made.points, made.tris, x);
    CHECK(after == Approx(before > 0.5 ? 1 : 0).margin(1e-6));
  }
}

}  // namespace

TEST_CASE("winding numbers of a sphere and of one within another") {
  Facets spheres = make_sphere({0, 0, 0}, 1, 2);
  CHECK(detail::winding_number(spheres.points, spheres.triangles, {0.1, 0.2, 0.3}) == Approx(1));
  CHECK(detail::winding_number(spheres.points, spheres.triangles, {2, 0, 0}) == Approx(0).margin(1e-12));
  const Vec3 on = (spheres.points[spheres.triangles[0][0]] + spheres.points[spheres.triangles[0][1]] +
                   spheres.points[spheres.triangles[0][2]]) /
                  3;
  CHECK(detail::winding_number(spheres.points, spheres.triangles, on, 0) == Approx(0.5));
  append(spheres, make_sphere({0, 0, 0}, 0.5, 2));
  CHECK(detail::winding_number(spheres.points, spheres.triangles, {0.1, 0.2, 0.3}) == Approx(2));
}

TEST_CASE("facets that do not cross stay as they are") {
  const Facets torus = make_torus(2, 0.5, 40, 20);
  CHECK_FALSE(detail::uncross_facets(torus.points, torus.triangles, nullptr).has_value());
}

TEST_CASE("a tube that passes through itself becomes what it encloses") {
  for (std::uint32_t seed = 0; seed < 12; ++seed) {
    CAPTURE(seed);
    std::mt19937 random(seed);
    Facets eight = make_eight(0.2 + 0.02 * seed);
    if (seed > 0) move_at_random(eight, 0.01, random);
    const auto made = detail::uncross_facets(eight.points, eight.triangles, nullptr);
    REQUIRE(made.has_value());
    check_union(eight, *made, random);
    CHECK(volume_of(*made) < 0.999 * shapes::volume_of(eight));
  }
}

TEST_CASE("shells that cross several times, three facets in one point among them, become one") {
  for (std::uint32_t seed = 0; seed < 6; ++seed) {
    CAPTURE(seed);
    std::mt19937 random(100 + seed);
    Facets shells;
    for (int axis = 0; axis < 3; ++axis) {
      Vec3 half{0.7 + 0.01 * axis, 0.72 + 0.01 * axis, 0.74 + 0.01 * axis};
      half[axis] = 2;
      append(shells, make_box(-half, half, 1 + seed));
    }
    append(shells, make_sphere({0.41, 0.32, 0.23}, 1.1, 2));
    Facets welded = weld(shells);
    move_at_random(welded, 0.02, random);
    const auto made = detail::uncross_facets(welded.points, welded.triangles, nullptr);
    REQUIRE(made.has_value());
    check_union(welded, *made, random);
  }
}

TEST_CASE("facets that lie on each other are told apart by a step that nobody sees") {
  Facets boxes = weld(make_box({0, 0, 0}, {2, 2, 2}, 2));
  append(boxes, weld(make_box({1.1, 0, 0}, {3, 2, 2}, 3)));
  const auto made = detail::uncross_facets(boxes.points, boxes.triangles, nullptr);
  REQUIRE(made.has_value());
  CHECK(volume_of(*made) == Approx(12).epsilon(1e-6));
}

TEST_CASE("two boxes whose sides may lie in one plane become one closed surface") {
  for (std::uint32_t seed = 0; seed < 400; ++seed) {
    CAPTURE(seed);
    std::mt19937 random(seed);
    const auto draw = [&](unsigned most) { return static_cast<double>(random() % most); };
    const Vec3 size{1 + draw(4), 1 + draw(4), 1 + draw(4)}, corner{draw(4), draw(4), draw(4)};
    Facets boxes = weld(make_box({0, 0, 0}, {4, 4, 4}, 1 + random() % 3));
    append(boxes, weld(make_box(corner, corner + size, 1 + random() % 3)));
    double common = 1;
    bool sticks_out = false;
    for (int axis = 0; axis < 3; ++axis) {
      common *= std::min(4.0, corner[axis] + size[axis]) - corner[axis];
      sticks_out = sticks_out || corner[axis] + size[axis] > 4;
    }
    if (!sticks_out) continue;
    const auto made = detail::uncross_facets(boxes.points, boxes.triangles, nullptr);
    REQUIRE(made.has_value());
    CHECK(detail::find_edges(made->tris, made->points.size()).open_count() == 0);
    CHECK(volume_of(*made) == Approx(64 + size.x * size.y * size.z - common).epsilon(1e-6));
  }
}

TEST_CASE("a region of facets that crosses itself is made anew, with its groups") {
  Facets eight = make_eight(0.3);
  detail::FacetSoup soup{eight.points, eight.triangles, {}, {"far", "near"}, {}};
  for (const Triangle& t : eight.triangles) soup.tri_to_group.push_back(eight.points[t[0]].x > 0 ? 1 : 0);
  const ModelDocument crossing = detail::build_discrete_model(std::move(soup), {}, nullptr);
  REQUIRE(crossing.model->topology().region_count() == 1);
  const auto rebuilt = detail::rebuild_regions(crossing, {ModelRegionId(0)}, nullptr);
  REQUIRE(rebuilt.has_value());
  CHECK(rebuilt->model->topology().region_count() == 1);
  CHECK(rebuilt->healing.back().what == "solids that crossed themselves were made anew");
  CHECK(rebuilt->healing.back().count == 1);
  CHECK(rebuilt->model->volume(ModelRegionId(0)) < 0.99 * crossing.model->volume(ModelRegionId(0)));
  std::set<std::string> names;
  for (std::size_t f = 0; f < rebuilt->model->topology().face_count(); ++f)
    names.insert(rebuilt->model->attributes(ModelFaceId(f)).name);
  CHECK(names == std::set<std::string>{"far", "near"});
  CHECK_FALSE(detail::rebuild_regions(*rebuilt, {ModelRegionId(0)}, nullptr).has_value());
}

TEST_CASE("what cannot be made anew is left alone") {
  const Facets box = make_box({0, 0, 0}, {1, 1, 1});
  const ModelDocument plain = detail::build_discrete_model({box.points, box.triangles, {}, {}, {}}, {}, nullptr);
  CHECK_FALSE(detail::rebuild_regions(plain, {}, nullptr).has_value());
  CHECK_FALSE(detail::rebuild_regions(plain, {ModelRegionId(7)}, nullptr).has_value());
  CHECK_FALSE(detail::rebuild_regions(plain, {ModelRegionId(0)}, nullptr).has_value());
  CHECK_FALSE(detail::rebuild_regions({}, {ModelRegionId(0)}, nullptr).has_value());
}

TEST_CASE("making regions anew can be cancelled") {
  const Facets eight = make_eight(0.3);
  CancelToken cancel;
  cancel.cancel();
  CHECK_THROWS_AS(detail::uncross_facets(eight.points, eight.triangles, &cancel), Error);
}
