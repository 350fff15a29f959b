#include "core/spatial/constrained_delaunay.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>
#include <random>

#include "core/predicates/predicates.hpp"

using namespace tetloom;

namespace {

using Segments = std::vector<std::array<std::uint32_t, 2>>;

void add_ring(std::vector<Vec2>& points, Segments& segments, const std::vector<Vec2>& ring) {
  const auto first = static_cast<std::uint32_t>(points.size()), n = static_cast<std::uint32_t>(ring.size());
  points.insert(points.end(), ring.begin(), ring.end());
  for (std::uint32_t i = 0; i < n; ++i) segments.push_back({first + i, first + (i + 1) % n});
}

double ring_area(const std::vector<Vec2>& ring) {
  double area = 0;
  for (std::size_t i = 0; i < ring.size(); ++i) area += 0.5 * cross(ring[i], ring[(i + 1) % ring.size()]);
  return area;
}

double mesh_area(const Triangulation& mesh, const std::vector<Vec2>& points) {
  double area = 0;
  for (std::uint32_t tri = 0; tri < mesh.slots(); ++tri) {
    const auto [a, b, c] = mesh.triangle(tri);
    REQUIRE(orient2d(points[a], points[b], points[c]) > 0);
    area += 0.5 * cross(points[b] - points[a], points[c] - points[a]);
  }
  return area;
}

std::vector<Vec2> star(std::mt19937& random, std::size_t n, double lo, double hi) {
  std::vector<Vec2> ring;
  std::uniform_real_distribution<double> radius(lo, hi);
  for (std::size_t i = 0; i < n; ++i) {
    const double angle = 2 * std::numbers::pi * static_cast<double>(i) / static_cast<double>(n), r = radius(random);
    ring.push_back({r * std::cos(angle), r * std::sin(angle)});
  }
  return ring;
}

}  // namespace

TEST_CASE("a square with a hole keeps its segments and its area") {
  std::vector<Vec2> points;
  Segments segments;
  add_ring(points, segments, {{0, 0}, {4, 0}, {4, 4}, {0, 4}});
  add_ring(points, segments, {{1, 1}, {1, 2}, {2, 2}, {2, 1}});
  const PolygonTriangulation result = triangulate_polygon(points, segments);
  REQUIRE(result.verdict == PolygonVerdict::Ok);
  CHECK(mesh_area(result.triangulation, points) == Approx(15));
  for (const auto& [a, b] : segments) {
    const std::uint32_t h = result.triangulation.find_half_edge(a, b);
    REQUIRE(h != Triangulation::kNone);
    CHECK(result.triangulation.fixed(h) == 1);
  }
}

TEST_CASE("random star polygons with random holes are filled exactly") {
  for (unsigned seed = 0; seed < 200; ++seed) {
    INFO("seed " << seed);
    std::mt19937 random(seed);
    std::vector<Vec2> points;
    Segments segments;
    const auto outer = star(random, 3 + random() % 60, 1, 3), inner = star(random, 3 + random() % 30, 0.05, 0.45);
    add_ring(points, segments, outer);
    add_ring(points, segments, inner);
    const PolygonTriangulation result = triangulate_polygon(points, segments);
    if (outer.size() < 6) continue;  // the hole may stick out of a triangle
    REQUIRE(result.verdict == PolygonVerdict::Ok);
    CHECK(result.triangulation.validate());
    CHECK(mesh_area(result.triangulation, points) == Approx(ring_area(outer) - ring_area(inner)));
  }
}

TEST_CASE("a segment given twice is an edge with the face on both sides") {
  std::vector<Vec2> points;
  Segments segments;
  add_ring(points, segments, {{0, 0}, {4, 0}, {4, 4}, {0, 4}});
  points.push_back({2, 2});
  segments.push_back({0, 4});
  segments.push_back({4, 0});
  const PolygonTriangulation result = triangulate_polygon(points, segments);
  REQUIRE(result.verdict == PolygonVerdict::Ok);
  CHECK(mesh_area(result.triangulation, points) == Approx(16));
  CHECK(result.triangulation.fixed(result.triangulation.find_half_edge(0, 4)) == 2);
}

TEST_CASE("crossing segments are named") {
  const std::vector<Vec2> points{{0, 0}, {4, 0}, {4, 4}, {0, 4}, {2, -1}, {2, 5}};
  const Segments segments{{0, 1}, {1, 2}, {2, 3}, {3, 0}, {4, 5}};
  const PolygonTriangulation result = triangulate_polygon(points, segments);
  CHECK(result.verdict == PolygonVerdict::SegmentsCross);
  CHECK(result.first == 4);
  CHECK((result.second == 0 || result.second == 2));
}

TEST_CASE("a point on a segment is named") {
  const std::vector<Vec2> points{{0, 0}, {4, 0}, {4, 4}, {0, 4}, {2, 0}, {3, 2}, {1, 2}};
  const Segments segments{{0, 1}, {1, 2}, {2, 3}, {3, 0}, {4, 5}, {5, 6}, {6, 4}};
  const PolygonTriangulation result = triangulate_polygon(points, segments);
  CHECK(result.verdict == PolygonVerdict::PointOnSegment);
  CHECK(result.first == 0);
  CHECK(result.second == 4);
}

TEST_CASE("coinciding points and open polygons are refused") {
  CHECK(triangulate_polygon(std::vector<Vec2>{{0, 0}, {1, 0}, {0, 1}, {1, 0}}, Segments{{0, 1}, {1, 2}, {2, 0}})
            .verdict == PolygonVerdict::DuplicatePoint);
  CHECK(triangulate_polygon(std::vector<Vec2>{{0, 0}, {1, 0}, {0, 1}}, Segments{{0, 1}, {1, 2}}).verdict ==
        PolygonVerdict::NotClosed);
  CHECK(triangulate_polygon(std::vector<Vec2>{}, Segments{}).verdict == PolygonVerdict::NotClosed);
}
