// The questions that the edges and faces of a discrete model answer, against brute force and known shapes.
#include <algorithm>
#include <catch2/catch.hpp>
#include <random>
#include <set>

#include "core/discrete/facet_bvh.hpp"
#include "core/discrete/polygon.hpp"
#include "tests/core/discrete_shapes.hpp"
#include "tetloom/model.hpp"

using namespace tetloom;
using namespace tetloom::shapes;

namespace {

Vec3 random_point(std::mt19937& random, double reach) {
  std::uniform_real_distribution<double> coordinate(-reach, reach);
  const double x = coordinate(random), y = coordinate(random), z = coordinate(random);
  return {x, y, z};
}

/// The distance from x to a triangle by a fine search over barycentric coordinates, good to about 1e-9 of its size.
double searched_distance(const Vec3& x, const Vec3& a, const Vec3& b, const Vec3& c) {
  // Exact candidates: the plane's foot where it is inside, else the three sides.
  const auto to_segment = [&](const Vec3& p, const Vec3& q) {
    const double s = std::clamp(dot(x - p, q - p) / norm2(q - p), 0.0, 1.0);
    return distance(x, p + s * (q - p));
  };
  double best = std::min({to_segment(a, b), to_segment(b, c), to_segment(c, a)});
  const Vec3 n = cross(b - a, c - a), foot = x - (dot(x - a, n) / norm2(n)) * n;
  const bool inside =
      dot(cross(b - a, foot - a), n) >= 0 && dot(cross(c - b, foot - b), n) >= 0 && dot(cross(a - c, foot - c), n) >= 0;
  return inside ? std::min(best, distance(x, foot)) : best;
}

}  // namespace

TEST_CASE("closest_point agrees with brute force, with and without a guess, and evaluate gives it back") {
  const unsigned seed = 11;
  INFO("seed " << seed);
  std::mt19937 random(seed);
  const Facets torus = make_torus(3, 1, 30, 17);
  const auto model = model_of(torus);
  const auto face = model->face_geometry(ModelFaceId(0));
  std::optional<Vec2> guess;
  for (int i = 0; i < 500; ++i) {
    const Vec3 x = random_point(random, 5);
    double expected = HUGE_VAL;
    for (const auto& [a, b, c] : torus.triangles) {
      expected = std::min(expected, searched_distance(x, torus.points[a], torus.points[b], torus.points[c]));
    }
    const SurfacePoint free = face->closest_point(x, std::nullopt), guided = face->closest_point(x, guess);
    CHECK(free.distance == Approx(expected).margin(1e-12));
    CHECK(guided.distance >= expected - 1e-12);
    if (guess) {
      // The guess picks the side: where the nearest facet does not face away from the guess, it is the answer.
      if (dot(face->normal(free.uv), face->normal(*guess)) > 0.5) {
        CHECK(guided.distance == Approx(expected).margin(1e-12));
      }
      CHECK(dot(face->normal(guided.uv), face->normal(*guess)) > -0.5);
    }
    CHECK(face->evaluate(free.uv) == free.point);
    CHECK(distance(x, free.point) == Approx(free.distance).margin(1e-14));
    const SurfacePoint again = face->closest_point(free.point, free.uv);
    CHECK(distance(again.point, free.point) < 1e-12);
    guess = free.uv;
  }
}

TEST_CASE("nearest points on long thin facets along any line are those of brute force") {
  const unsigned seed = 17;
  INFO("seed " << seed);
  std::mt19937 random(seed);
  const double spread = GENERATE(0.0, 0.3, 2.0);  // of the far ends: side by side, or like a fan
  const Vec3 along = normalized(Vec3{0.47, -0.88, -0.09}), across = normalized(cross(along, Vec3{0, 0, 1}));
  constexpr int kFacets = 300;
  std::vector<Vec3> points;
  std::vector<std::array<std::uint32_t, 3>> tris;
  for (int i = 0; i <= kFacets; ++i) {
    const double s = static_cast<double>(i) / kFacets - 0.5;
    points.push_back(0.3 * s * across + Vec3{0, 0, 0.1 * s * s});
    points.push_back(4.0 * along + spread * s * across);
    const auto last = static_cast<std::uint32_t>(points.size() - 1);
    if (i > 0) tris.push_back({last - 3, last - 1, last}), tris.push_back({last - 3, last, last - 2});
  }
  const detail::FacetBvh bvh(points, tris);
  for (int i = 0; i < 300; ++i) {
    const Vec3 x = i % 2 ? random_point(random, 3) : points[random() % points.size()] + random_point(random, 1e-4);
    double expected = HUGE_VAL;
    for (const auto& [a, b, c] : tris)
      expected = std::min(expected, closest_on_triangle(x, points[a], points[b], points[c]).distance2);
    const detail::FacetPoint found = bvh.closest(x);
    REQUIRE(found.place.distance2 == expected);
    const auto aim = static_cast<std::uint32_t>(random() % tris.size());
    const Vec3 center = (points[tris[aim][0]] + points[tris[aim][1]] + points[tris[aim][2]]) / 3;
    std::set<std::uint32_t> near_ray;
    bvh.for_each_near_ray(x, center - x, [&](std::uint32_t t) { near_ray.insert(t); });
    CHECK(near_ray.contains(aim));
  }
}

TEST_CASE("(u,v) at corners and sides of facets stay in their facets") {
  const auto model = model_of(make_box({0, 0, 0}, {1, 1, 1}, 3));
  const auto face = model->face_geometry(ModelFaceId(2));
  const Tessellation t = face->tessellate(1, 1);
  for (std::uint32_t tri = 0; tri < t.tri_to_vert.size(); ++tri) {
    const double u = 2.0 * tri;
    CHECK(face->evaluate({u, 0}) == t.points[t.tri_to_vert[tri][0]]);
    CHECK(face->evaluate({u + 1, 0}) == t.points[t.tri_to_vert[tri][1]]);
    CHECK(face->evaluate({u, 1}) == t.points[t.tri_to_vert[tri][2]]);
    const SurfaceDerivatives d = face->derivatives({u + 0.25, 0.5});
    CHECK(distance(d.point, t.points[t.tri_to_vert[tri][0]] + 0.25 * d.du + 0.5 * d.dv) < 1e-15);
    CHECK(dot(normalized(cross(d.du, d.dv)), face->normal({u + 0.25, 0.5})) == Approx(1));
  }
  CHECK(face->parametrization() == Parametrization::Piecewise);
  CHECK_THROWS_AS(face->edge_parameters({ModelEdgeId(0), true, false}, 0), Error);
}

TEST_CASE("nearest points of degenerate triangles are nearest points of their sides") {
  const Vec3 a{0, 0, 0}, b{1, 0, 0}, c{3, 0, 0};
  for (const Vec3& x : {Vec3{2, 1, 0}, Vec3{-1, 0, 0}, Vec3{5, 0, 1}, Vec3{0.5, 0, 0}}) {
    const double expected = distance(x, Vec3{std::clamp(x.x, 0.0, 3.0), 0, 0});
    CHECK(std::sqrt(closest_on_triangle(x, a, b, c).distance2) == Approx(expected).margin(1e-12));
    CHECK(std::sqrt(closest_on_triangle(x, c, a, b).distance2) == Approx(expected).margin(1e-12));
  }
  CHECK(closest_on_triangle({1, 0, 0}, a, a, a).distance2 == Approx(1));
}

TEST_CASE("the curvature of a sphere is -1/r everywhere, to 10 %") {
  const double radius = 2.5;
  const bool uneven = GENERATE(false, true);
  // Uneven: thin facets, more of them around than along, and cut poles.
  const Facets sphere =
      uneven ? make_grid(64, 24, false,
                         [&](std::uint32_t i, std::uint32_t j) {
                           const double a = 2 * M_PI * i / 64, b = -1.3 + 2.6 * j / 24;
                           return radius * Vec3{std::cos(a) * std::cos(b), std::sin(a) * std::cos(b), std::sin(b)};
                         })
             : make_sphere({0, 0, 0}, radius, 3);
  const auto model = model_of(sphere);
  const auto face = model->face_geometry(ModelFaceId(0));
  double worst = 0, worst_normal = 0;
  for (std::size_t tri = 0; tri < sphere.triangles.size(); ++tri) {
    for (const Vec2 b : {Vec2{1. / 3, 1. / 3}, Vec2{0, 0}, Vec2{1, 0}, Vec2{0.2, 0.8}}) {
      const Vec2 uv{2.0 * static_cast<double>(tri) + b.u, b.v};
      const PrincipalCurvatures k = face->curvature(uv);
      worst = std::max({worst, std::abs(k.largest * radius + 1), std::abs(k.smallest * radius + 1)});
      worst_normal = std::max(worst_normal, norm(face->normal(uv) - normalized(face->evaluate(uv))));
    }
  }
  CAPTURE(uneven, worst, worst_normal);
  CHECK(worst < 0.10);
  CHECK(worst_normal < 0.03);
}

TEST_CASE("the curvature of a cylinder's side is -1/r around and 0 along, to 10 %, and 0 on its flat ends") {
  const std::uint32_t rows = GENERATE(1, 5);
  const auto model = model_of(make_cylinder(0.5, 2, 32, rows));
  const auto side = model->face_geometry(ModelFaceId(0)), end = model->face_geometry(ModelFaceId(1));
  for (std::uint32_t tri = 0; tri < 32 * rows * 2; ++tri) {
    for (const Vec2 b : {Vec2{1. / 3, 1. / 3}, Vec2{0, 0}, Vec2{1, 0}, Vec2{0.2, 0.8}}) {
      const PrincipalCurvatures k = side->curvature({2.0 * tri + b.u, b.v});
      CHECK(k.largest == Approx(-2).epsilon(0.1));
      CHECK(std::abs(k.smallest) < 0.1);
    }
  }
  for (std::uint32_t tri = 0; tri < 32; ++tri) CHECK(std::abs(end->curvature({2.0 * tri + 0.3, 0.3}).largest) < 1e-9);
}

TEST_CASE("the curvature of a torus has the signs and sizes of its place") {
  const auto model = model_of(make_torus(3, 1, 96, 48));
  const auto face = model->face_geometry(ModelFaceId(0));
  const PrincipalCurvatures outer = face->curvature(face->closest_point({4, 0, 0}, std::nullopt).uv);
  CHECK(outer.largest == Approx(-1).epsilon(0.05));
  CHECK(outer.smallest == Approx(-0.25).epsilon(0.1));
  const PrincipalCurvatures inner = face->curvature(face->closest_point({2, 0, 0}, std::nullopt).uv);
  CHECK(inner.largest == Approx(-1).epsilon(0.05));
  CHECK(inner.smallest == Approx(0.5).epsilon(0.1));
}

TEST_CASE("an edge's closest point agrees with brute force, and evaluate with its arc length") {
  const unsigned seed = 5;
  INFO("seed " << seed);
  std::mt19937 random(seed);
  const auto model = model_of(make_cylinder(1, 3, 100, 2));
  const auto edge = model->edge_geometry(ModelEdgeId(0));
  const double length = edge->range().hi;
  for (int i = 0; i < 200; ++i) {
    const Vec3 x = random_point(random, 2);
    const CurvePoint found = edge->closest_point(x);
    double expected = HUGE_VAL;
    for (int k = 0; k < 20000; ++k) expected = std::min(expected, distance(x, edge->evaluate(length * k / 20000)));
    CHECK(found.distance <= expected + 1e-12);
    CHECK(found.distance > expected - 1e-4);
    CHECK(distance(edge->evaluate(found.t), found.point) < 1e-12);
    CHECK(norm(edge->derivative(found.t)) == Approx(1));
  }
  const double h = 1e-6, t = 0.3 * length;
  CHECK(distance(edge->evaluate(t + h), edge->evaluate(t)) == Approx(h).epsilon(1e-6));
}

TEST_CASE("polygons are cut into triangles of their area that lie inside") {
  const unsigned seed = 3;
  INFO("seed " << seed);
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> unit(0.3, 1);
  for (const std::size_t corners : {4u, 5u, 9u, 40u, 150u}) {
    for (const bool convex : {false, true}) {
      std::vector<Vec3> ring;
      double area = 0;
      for (std::size_t i = 0; i < corners; ++i) {
        const double angle = 2 * M_PI * static_cast<double>(i) / static_cast<double>(corners),
                     rho = convex ? 1 : unit(random);
        ring.push_back({rho * std::cos(angle), 1, -rho * std::sin(angle)});
      }
      for (std::size_t i = 0; i < corners; ++i) area += cross(ring[i], ring[(i + 1) % corners]).y / 2;
      double sum = 0;
      std::size_t inverted = 0;
      const auto triangles = detail::triangulate_polygon(ring);
      for (const auto& [a, b, c] : triangles) {
        const double part = cross(ring[b] - ring[a], ring[c] - ring[a]).y / 2;
        sum += part, inverted += part < -1e-12;
      }
      CHECK(triangles.size() == corners - 2);
      CHECK(inverted == 0);
      CHECK(std::abs(sum) == Approx(std::abs(area + 0 * area)).epsilon(1e-9));
    }
  }
}

TEST_CASE("noise of the points does not pass for curvature, and a coarse fillet keeps its own") {
  std::mt19937 random(11);
  std::uniform_real_distribution<double> noise(-0.004, 0.004);
  Facets sphere = make_sphere({0, 0, 0}, 1, 5);  // edges of 0.04
  for (Vec3& p : sphere.points) p = (1 + noise(random)) * p;
  const auto curvature_of = [](const Facets& facets) {
    const auto model = make_discrete_model(facets.points, facets.triangles, 0.7);
    const auto face = model->face_geometry(ModelFaceId(0));
    const Tessellation t = face->tessellate(1, 1);
    std::vector<double> values;
    for (const Vec2& uv : t.uv) values.push_back(std::abs(face->curvature(uv).largest));
    std::sort(values.begin(), values.end());
    return std::array{values[values.size() / 2], values[values.size() * 95 / 100]};
  };
  const auto [median, high] = curvature_of(sphere);
  CHECK(median > 0.5);
  CHECK(median < 2.5);
  CHECK(high < 4);  // without a filter, 10
  // A corrugated sheet of eight facets a wave keeps its crests.
  const Facets waves = make_grid(
      64, 20, false,
      [](std::uint32_t i, std::uint32_t j) {
        return Vec3{0.1 * i, 0.1 * j, 0.05 * std::sin(M_PI_4 * i)};
      },
      false);
  CHECK(curvature_of(waves)[1] > 2);
}
