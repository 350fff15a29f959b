// Cells of fans, by themselves.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <map>
#include <set>

#include "mesher/layers/spherical_polygon.hpp"
#include "mesher/layers/stack_cells.hpp"

using namespace tetloom;
using namespace tetloom::layers;

namespace {

// An edge from (0,0,0) to (0,1,0) between a wall to the left, with curves 0 and 3 upwards, and one that falls away,
// with curves 1 and 2 to the right. Curve 4 stands at the first end alone, curve 5 points along the edge there.
Walls edge_walls(FanElement::Kind kind, std::array<std::uint32_t, 4> curves) {
  Walls walls;
  walls.curve_to_vert = {0, 0, 1, 1, 0, 0};
  walls.curve_is_late = {0, 0, 0, 0, 1, 0};
  walls.curve_to_fan_vertex = {0, 0, 1, 1, kNone, 0};
  walls.fan_vertices = {{{0, 1, 5}}, {{2, 3}}};
  walls.fans = {{kind, curves, 0}};
  return walls;
}

Vec3 point(const CurveLevel& at, const std::array<int, 6>& counts) {
  if (at.is_apex()) return {0.4, 0.5, 0.4 + 0.1 * counts[2]};
  const std::array<Vec3, 6> ways{Vec3{0, 0, 1}, {1, 0, 0}, {1, 0, 0}, {0, 0, 1}, {0.7, 0, 0.7}, {0, -1, 0}};
  const double y = at.curve == 2 || at.curve == 3 ? 1 : 0;
  return Vec3{0, y, 0} + 0.1 * at.level * ways[at.curve];
}

struct Filled {
  double volume = 0;
  std::map<CellKind, int> cells;
  std::map<std::set<std::pair<std::uint32_t, int>>, int> faces;  // how many cells have each
};

Filled fill(const Walls& walls, const std::array<int, 6>& counts) {
  Filled filled;
  for_each_cell_on(
      walls, 0, [&](std::uint32_t c) { return counts[c]; },
      [&](const auto& cell, int layer) {
        constexpr std::size_t kVertices = std::tuple_size_v<std::decay_t<decltype(cell)>>;
        std::array<Vec3, kVertices> x;
        for (std::size_t i = 0; i < kVertices; ++i) x[i] = point(cell[i], counts);
        CHECK(is_positive(x));
        CHECK(layer >= 1);
        ++filled.cells[kind_of_cell(kVertices)];
        split_cell(walls, cell, [&](const std::array<CurveLevel, 4>& tet) {
          std::array<Vec3, 4> t;
          for (std::size_t i = 0; i < 4; ++i) t[i] = point(tet[i], counts);
          CHECK(is_positive(t));
          filled.volume += dot(cross(t[1] - t[0], t[2] - t[0]), t[3] - t[0]) / 6;
          for (const LocalFace& face : shape_of(CellKind::Tet).faces()) {
            std::set<std::pair<std::uint32_t, int>> key;
            for (const std::uint8_t v : face.vertices())
              key.insert({tet[v].level == 0 ? walls.first_at_foot(tet[v].curve) : tet[v].curve, tet[v].level});
            ++filled.faces[key];
          }
        });
      });
  CHECK(std::ranges::all_of(filled.faces, [](const auto& face) { return face.second <= 2; }));
  return filled;
}

}  // namespace

TEST_CASE("a fan on an edge is filled with positive cells, whatever the counts of its ends") {
  const Walls walls = edge_walls(FanElement::Kind::Quad, {0, 1, 2, 3});
  for (int p = 0; p <= 3; ++p)
    for (int q = 0; q <= 3; ++q) {
      Filled filled = fill(walls, {p, p, q, q, 0, 0});
      const int low = std::min(p, q), steps = std::max(p, q) - low;
      CHECK(filled.cells[CellKind::Hex] == std::max(low - 1, 0));
      CHECK(filled.cells[CellKind::Prism] == (low > 0 ? 1 + steps : 0));
      CHECK(filled.cells[CellKind::Tet] == (low == 0 && steps > 0 ? 1 : 0));
      CHECK(filled.cells[CellKind::Pyramid] == (low > 0 ? 1 : std::max(steps - 1, 0)));
      const double a = 0.1 * p, b = 0.1 * q;  // a wedge whose height varies along the edge
      if (low == 0) CHECK(filled.volume == Approx((a * a + a * b + b * b) / 6));
    }
}

TEST_CASE("the end of a fan is filled beside a curve that grows late") {
  const Walls walls = edge_walls(FanElement::Kind::End, {4, 2, 3, kNone});
  for (int a = 0; a <= 3; ++a)
    for (int q = 0; q <= 3; ++q) {
      Filled filled = fill(walls, {0, 0, q, q, a, 0});
      const int cells = filled.cells[CellKind::Tet] + filled.cells[CellKind::Pyramid] + filled.cells[CellKind::Prism];
      CHECK(cells == (q == 0 ? 0 : std::max(a, q) + (a > 0 ? 1 : 0)));
      CHECK((filled.volume > 0) == (q > 0));
    }
}

TEST_CASE("a corner between three curves of a fan starts with a tet") {
  const Walls walls = edge_walls(FanElement::Kind::Corner, {0, 5, 1, kNone});
  for (int n = 0; n <= 3; ++n) {
    Filled filled = fill(walls, {n, n, 0, 0, 0, n});
    CHECK(filled.cells[CellKind::Tet] == std::min(n, 1));
    CHECK(filled.cells[CellKind::Prism] == std::max(n - 1, 0));
    CHECK(filled.volume == Approx(std::pow(0.1 * n, 3) / 6));
  }
}

TEST_CASE("a hexahedron is positive where its prisms are, and its scaled Jacobian is that of its corners") {
  std::array<Vec3, 8> hex{Vec3{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {0, 0, 1}, {1, 0, 1}, {1, 1, 1}, {0, 1, 1}};
  CHECK(is_positive(hex));
  CHECK(scaled_jacobian(hex) == Approx(1));
  CHECK(is_sound(hex, 0.99));
  // Thin and twisted, below and above alike.
  for (Vec3& x : hex) x.z *= 0.05;
  for (const std::size_t i : {1, 5}) hex[i].z += 0.2;
  CHECK(is_positive(hex));
  hex[6] = {0.3, 0.3, 0.05};
  CHECK_FALSE(is_positive(hex));
  CHECK_FALSE(is_sound(hex, 1e-6));
}

TEST_CASE("late curves grow after the others of the first layer") {
  for (int late = 0; late < 8; ++late)
    for (const std::array<int, 3>& counts : {std::array{1, 1, 1}, {2, 1, 3}, {0, 2, 1}}) {
      double volume = 0;
      int top = 0;
      for_each_cell(counts, {(late & 1) != 0, (late & 2) != 0, (late & 4) != 0},
                    [&](CellKind kind, const auto& corners) {
                      std::array<Vec3, std::tuple_size_v<std::decay_t<decltype(corners)>>> x;
                      const std::array<Vec3, 3> foot{Vec3{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
                      for (std::size_t i = 0; i < x.size(); ++i) {
                        x[i] = foot[corners[i].corner] + Vec3{0, 0, 0.1 * corners[i].level};
                        top = std::max(top, corners[i].level);
                      }
                      CHECK(is_positive(x));
                      volume += 0.05 * (kind == CellKind::Prism ? 1.0 : kind == CellKind::Pyramid ? 2.0 / 3 : 1.0 / 3);
                    });
      CHECK(volume == Approx(0.05 * (counts[0] + counts[1] + counts[2]) / 3));
      CHECK(top == std::ranges::max(counts));
    }
}

TEST_CASE("polygons of directions are triangulated so that the flattest triangle is least flat") {
  const std::vector<Vec3> octant{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  CHECK(triangulate_on_sphere(octant).least == Approx(1));
  CHECK(triangulate_on_sphere(octant).triangles == std::vector<std::array<std::uint32_t, 3>>{{0, 1, 2}});
  // Up, backwards, down, aside: the tip of a wing. Up and down are opposite to each other.
  const std::vector<Vec3> tip{{0, 0, 1}, {1, 0, 0}, {0, 0, -1}, {0, 1, 0}};
  const SphericalTriangulation found = triangulate_on_sphere(tip);
  CHECK(found.least == Approx(1));
  REQUIRE(found.triangles.size() == 2);
  for (const auto& triangle : found.triangles) {
    CHECK(std::ranges::count(triangle, 1) == 1);
    CHECK(std::ranges::count(triangle, 3) == 1);
  }
  const std::vector<Vec3> clockwise{{1, 0, 0}, {0, 0, 1}, {0, 1, 0}};
  CHECK(triangulate_on_sphere(clockwise).least == Approx(-1));
}
