// Edges at which bodies touch, split before anything else.
#include "adapt/touching_edges.hpp"
#include "tests/adapt/uniform_metric.hpp"
#include "tetloom/tasks.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <limits>

#include "core/mesh/mesh_access.hpp"
#include "tests/adapt/kept_mesh.hpp"
#include "tests/adapt/touching_blocks.hpp"
#include "tests/support/analytic_model.hpp"
#include "tests/support/mixed_mesh.hpp"
#include "tetloom/adapt.hpp"

using namespace tetloom;
using namespace tetloom::adapt;

namespace {

constexpr std::size_t kAny = std::numeric_limits<std::size_t>::max();

const TouchingShape& in_an_edge() { return kTouchingShapes[0]; }

/// The longest edge that two tets have which do not hang together around it, in a mesh of two regions that share
/// nothing else.
double longest_shared(const Mesh& mesh) {
  double longest = 0;
  std::vector<std::uint8_t> regions(mesh.points.size(), 0);
  for (std::size_t t = 0; t < mesh.tet_to_vert.size(); ++t)
    for (const std::uint32_t v : mesh.tet_to_vert[t])
      regions[v] |= static_cast<std::uint8_t>(mesh.tet_to_entity[t] + 1);
  for (const TetVerts& v : mesh.tet_to_vert)
    for (std::size_t i = 0; i < 4; ++i)
      for (std::size_t j = 0; j < i; ++j)
        if (regions[v[i]] == 3 && regions[v[j]] == 3)
          longest = std::max(longest, distance(mesh.points[v[i]], mesh.points[v[j]]));
  return longest;
}

double linear(const Vec3& x) { return 1 + 2 * x.x - 3 * x.y + 5 * x.z; }

double least_volume(const Mesh& mesh) {
  double least = HUGE_VAL;
  for (const auto& [a, b, c, d] : mesh.tet_to_vert) {
    const Vec3& x = mesh.points[a];
    least = std::min(least, dot(cross(mesh.points[b] - x, mesh.points[c] - x), mesh.points[d] - x) / 6);
  }
  return least;
}

/// Two tets that have an edge in common, a piece of the circle of radius 1 at which a cylinder begins: one inside, one
/// outside with a vertex at the radius `r` beside the edge's middle.
Mesh tets_on_circle(double r) {
  Mesh mesh;
  const double angle = std::acos(-1) / 3, c = std::cos(angle / 2), s = std::sin(angle / 2);
  mesh.points = {{1, 0, 0},         {std::cos(angle), std::sin(angle), 0},
                 {0, 0, 0},         {0.3, 0.2, 0.8},
                 {r * c, r * s, 0}, {1.5 * c, 1.5 * s, -0.8}};
  mesh.tet_to_vert = {{0, 1, 2, 3}, {0, 1, 4, 5}};
  mesh.tet_to_entity = {0, 0};
  for (TetVerts& v : mesh.tet_to_vert) {
    const auto& x = mesh.points;
    if (dot(cross(x[v[1]] - x[v[0]], x[v[2]] - x[v[0]]), x[v[3]] - x[v[0]]) < 0) std::swap(v[2], v[3]);
    for (std::size_t i = 0; i < 4; ++i) {
      mesh.tri_to_vert.push_back({v[i == 0], v[i <= 1 ? 2 : 1], v[i <= 2 ? 3 : 2]});
      mesh.tri_to_entity.push_back(static_cast<std::uint32_t>(mesh.tri_to_entity.size()));
    }
  }
  mesh.edge_to_vert = {{0, 1}}, mesh.edge_to_entity = {0};
  return mesh;
}

}  // namespace

TEST_CASE("meshes without edges at which bodies touch are left alone, and short ones of these", "[adapt]") {
  const Mesh box = test::make_tet_box(2, 2, 2, 1, true);
  CHECK(!split_touching_edges(box, test::uniform_metric(box, 0.01), {}, nullptr, kAny));
  const Mesh vertex = mesh_of(kTouchingShapes[2], 1);
  CHECK(!split_touching_edges(vertex, test::uniform_metric(vertex, 0.01), {}, nullptr, kAny));
  const Mesh edge = mesh_of(in_an_edge(), 2);
  CHECK(!split_touching_edges(edge, test::uniform_metric(edge, 0.2), {}, nullptr, kAny));
  CHECK(split_touching_edges(edge, test::uniform_metric(edge, 0.17), {}, nullptr, kAny));
}

TEST_CASE("edges at which bodies touch are split for all of them alike, with fields", "[adapt]") {
  Mesh mesh = mesh_of(in_an_edge(), 2);
  MeshField on_points{"linear", 1, {}}, on_cells{"number", 2, {}};
  for (const Vec3& x : mesh.points) on_points.values.push_back(linear(x));
  for (std::size_t t = 0; t < mesh.tet_to_vert.size(); ++t)
    on_cells.values.insert(on_cells.values.end(), {static_cast<double>(t), mesh.tet_to_entity[t] + 0.5});
  mesh.point_fields = {on_points}, mesh.cell_fields = {on_cells};
  const double h = 0.03;
  const MetricFunction function = [&](const Vec3&) { return isotropic(h); };
  for (const bool has_function : {false, true}) {
    const auto split = split_touching_edges(mesh, test::uniform_metric(mesh, h),
                                            has_function ? function : MetricFunction(), nullptr, kAny);
    REQUIRE(split);
    require_consistent(split->mesh);
    test::check_kept(mesh, make_mesh_of(make_whole_mesh(split->mesh, TaskRunner(1)), split->mesh, TaskRunner(1)));
    CHECK(longest_shared(split->mesh) <= std::sqrt(2.0) * h);
    REQUIRE(split->metric.size() == split->mesh.points.size());
    for (std::size_t v = 0; v < split->mesh.points.size(); ++v) {
      CHECK(std::abs(split->metric.logs[v].xx + 2 * std::log(h)) < 1e-12);
      CHECK(std::abs(split->mesh.point_fields[0].values[v] - linear(split->mesh.points[v])) < 1e-12);
    }
    for (std::size_t t = 0; t < split->mesh.tet_to_vert.size(); ++t) {
      const double* values = &split->mesh.cell_fields[0].values[2 * t];
      CHECK(values[1] == split->mesh.tet_to_entity[t] + 0.5);
      if (t < mesh.tet_to_vert.size()) CHECK(values[0] == static_cast<double>(t));
    }
  }
}

TEST_CASE("a metric of any sizes ends with the tets allowed", "[adapt]") {
  const Mesh mesh = mesh_of(in_an_edge(), 1);
  MetricField metric = test::uniform_metric(mesh, 1);
  for (std::size_t v = 0; v < mesh.points.size(); v += 3) metric.logs[v] = log(isotropic(1e-40));
  const auto split = split_touching_edges(mesh, metric, {}, nullptr, 500);
  REQUIRE(split);
  CHECK(split->mesh.tet_to_vert.size() >= 500);
  CHECK(split->mesh.tet_to_vert.size() < 520);
}

TEST_CASE("points of an edge at which bodies touch lie on the model where that inverts nothing", "[adapt]") {
  const auto cylinder = test_models::make_cylinder(1, 1);
  const Mesh mesh = tets_on_circle(1.5);
  const auto split = split_touching_edges(mesh, test::uniform_metric(mesh, 0.2), {}, cylinder.get(), kAny);
  REQUIRE(split);
  REQUIRE(split->mesh.points.size() > mesh.points.size() + 2);
  for (std::size_t v = mesh.points.size(); v < split->mesh.points.size(); ++v)
    CHECK(std::abs(norm(split->mesh.points[v]) - 1) < 1e-9);
  CHECK(least_volume(split->mesh) > 0);

  const Mesh narrow = tets_on_circle(0.95);
  const auto straight = split_touching_edges(narrow, test::uniform_metric(narrow, 0.6), {}, cylinder.get(), kAny);
  REQUIRE(straight);
  REQUIRE(straight->mesh.points.size() == narrow.points.size() + 1);
  CHECK(distance(straight->mesh.points.back(), 0.5 * (narrow.points[0] + narrow.points[1])) < 1e-12);
  CHECK(least_volume(straight->mesh) > 0);
}

TEST_CASE("a mesh that cannot be adapted is refused with its own elements, though edges are split", "[adapt]") {
  const Mesh mesh = mesh_of(in_an_edge(), 1);
  for (std::size_t t = 0; t < mesh.tri_to_vert.size(); ++t) {
    Mesh unnamed = mesh;
    unnamed.tri_to_entity[t] = kNone;
    const AdaptResult result = adapt_mesh(unnamed, test::uniform_metric(mesh, 0.1), {});
    CHECK(result.status == AdaptStatus::Failed);
    REQUIRE(result.errors.size() == 1);
    REQUIRE(result.errors[0].elements.size() == 1);
    REQUIRE(result.errors[0].elements[0] < mesh.tet_to_vert.size());
    const TetVerts& tet = mesh.tet_to_vert[result.errors[0].elements[0]];
    for (const std::uint32_t v : mesh.tri_to_vert[t]) CHECK(std::find(tet.begin(), tet.end(), v) != tet.end());
  }
}
