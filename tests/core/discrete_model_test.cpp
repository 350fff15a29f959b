// The topology that facets are cut into: faces, edges, loops, regions.
#include <algorithm>
#include <catch2/catch.hpp>
#include <map>
#include <random>
#include <set>

#include "core/geometry/model_projector.hpp"
#include "tests/core/discrete_shapes.hpp"
#include "tetloom/model.hpp"

using namespace tetloom;
using namespace tetloom::shapes;

namespace {

ModelVertexId start_of(const ModelTopology& topology, const EdgeUse& use) {
  return topology.edges[use.edge.value].vertices[use.forward ? 0 : 1];
}

ModelVertexId end_of(const ModelTopology& topology, const EdgeUse& use) {
  return topology.edges[use.edge.value].vertices[use.forward ? 1 : 0];
}

/// What holds of every model: closed loops, each manifold edge used once in each direction, tables that agree, points
/// of tessellations on the entities that they are classified on.
void check_invariants(const GeometricModel& model) {
  const ModelTopology& topology = model.topology();
  for (const auto& loops : topology.face_to_loops) {
    for (const ModelLoop& loop : loops) {
      REQUIRE(!loop.empty());
      for (std::size_t i = 0; i < loop.size(); ++i) {
        CHECK(end_of(topology, loop[i]) == start_of(topology, loop[(i + 1) % loop.size()]));
      }
    }
  }
  for (std::size_t edge = 0; edge < topology.edge_count(); ++edge) {
    const auto geometry = model.edge_geometry(ModelEdgeId(edge));
    const ParameterRange range = geometry->range();
    CHECK(range.lo == 0);
    CHECK(range.hi > 0);
    CHECK(geometry->evaluate(range.lo) == model.vertex_point(topology.edges[edge].vertices[0]));
    CHECK(geometry->evaluate(range.hi) == model.vertex_point(topology.edges[edge].vertices[1]));
  }
  for (std::size_t face = 0; face < topology.face_count(); ++face) {
    const auto geometry = model.face_geometry(ModelFaceId(face));
    const Tessellation t = geometry->tessellate(0.1, 0.1);
    double area = 0;
    for (const auto& [a, b, c] : t.tri_to_vert)
      area += norm(cross(t.points[b] - t.points[a], t.points[c] - t.points[a])) / 2;
    CHECK(area == Approx(model.area(ModelFaceId(face))));
    std::size_t wrong = 0;
    for (std::size_t i = 0; i < t.points.size(); ++i) {
      wrong += !(geometry->evaluate(t.uv[i]) == t.points[i]);
      const ModelEntity entity = t.classification[i];
      if (entity.dim == 0) wrong += !(model.vertex_point(ModelVertexId(entity.index)) == t.points[i]);
      if (entity.dim == 1) {
        wrong += distance(model.edge_geometry(ModelEdgeId(entity.index))->evaluate(t.edge_parameter[i]), t.points[i]) >
                 1e-12;
      }
      if (entity.dim == 2) wrong += entity.index != face;
    }
    CHECK(wrong == 0);
  }
  for (std::size_t region = 0; region < topology.region_count(); ++region) {
    CHECK(model.volume(ModelRegionId(region)) > 0);
    CHECK(std::is_sorted(topology.region_to_faces[region].begin(), topology.region_to_faces[region].end()));
    for (const ModelFaceId face : topology.region_to_faces[region]) {
      const FaceSides& sides = topology.face_to_sides[face.value];
      CHECK((sides.back.value == region || sides.front.value == region));
    }
  }
}

std::vector<std::size_t> loop_counts(const GeometricModel& model) {
  std::vector<std::size_t> counts;
  for (const auto& loops : model.topology().face_to_loops) counts.push_back(loops.size());
  return counts;
}

}  // namespace

TEST_CASE("a box has 6 faces whatever its groups, and more when a group divides a side") {
  Facets box = make_box({0, 0, 0}, {1, 1, 1}, 4);
  for (const bool with_groups : {false, true}) {
    const auto model = model_of(box, with_groups);
    check_invariants(*model);
    CHECK(model->topology().face_count() == 6);
    CHECK(model->topology().edge_count() == 12);
    CHECK(model->topology().vertex_count == 8);
    CHECK(loop_counts(*model) == std::vector<std::size_t>(6, 1));
    CHECK(model->volume(ModelRegionId(0)) == Approx(1));
    CHECK(model->area(ModelFaceId(3)) == Approx(1));
    for (const Vec3& corner : {Vec3{0, 0, 0}, Vec3{1, 1, 1}}) CHECK(model->bounding_box().contains(corner));
  }
  // The lower half of the first side (x = 0; its rows run along z) gets a group of its own.
  std::fill_n(box.groups.begin(), box.groups.size() / 12, 6u);
  const auto model = model_of(box, true);
  check_invariants(*model);
  CHECK(model->topology().face_count() == 7);
  CHECK(model->topology().edge_count() == 15);
  CHECK(model->topology().vertex_count == 10);
}

TEST_CASE("a sphere is one face without loops around one region") {
  const Facets sphere = make_sphere({1, 2, 3}, 2, 3);
  const auto model = model_of(sphere);
  check_invariants(*model);
  CHECK(loop_counts(*model) == std::vector<std::size_t>{0});
  CHECK(model->topology().edge_count() == 0);
  CHECK(model->topology().vertex_count == 0);
  REQUIRE(model->topology().region_count() == 1);
  CHECK(model->volume(ModelRegionId(0)) == Approx(volume_of(sphere) - 0).epsilon(1e-12));
  CHECK(model->area(ModelFaceId(0)) == Approx(area_of(sphere)));
}

TEST_CASE("a cylinder has three faces and two closed edges, its side two loops and no seam") {
  const auto model = model_of(make_cylinder(1, 3, 24, 6));
  check_invariants(*model);
  const ModelTopology& topology = model->topology();
  CHECK(loop_counts(*model) == std::vector<std::size_t>{2, 1, 1});
  REQUIRE(topology.edge_count() == 2);
  CHECK(topology.vertex_count == 2);
  for (std::size_t edge = 0; edge < 2; ++edge) {
    CHECK(topology.edges[edge].vertices[0] == topology.edges[edge].vertices[1]);
    const auto geometry = model->edge_geometry(ModelEdgeId(edge));
    const double length = 48 * std::sin(M_PI / 24);
    CHECK(geometry->period() == Approx(length));
    CHECK(distance(geometry->evaluate(0.4), geometry->evaluate(0.4 - length)) < 1e-12);
    CHECK(geometry->curvature(1.0) == Approx(1).epsilon(1e-9));
  }
  std::multiset<std::pair<std::uint32_t, bool>> uses;
  for (const auto& loops : topology.face_to_loops) {
    for (const ModelLoop& loop : loops) {
      for (const EdgeUse& use : loop) uses.insert({use.edge.value, use.forward});
    }
  }
  CHECK(uses == std::multiset<std::pair<std::uint32_t, bool>>{{0, false}, {0, true}, {1, false}, {1, true}});
}

TEST_CASE("a torus is one face without loops") {
  const Facets torus = make_torus(3, 1, 40, 20);
  const auto model = model_of(torus);
  check_invariants(*model);
  CHECK(loop_counts(*model) == std::vector<std::size_t>{0});
  CHECK(model->volume(ModelRegionId(0)) == Approx(std::abs(volume_of(torus))));
}

TEST_CASE("the nearest place on a face of facets does not depend on what was asked before") {
  const auto torus = model_of(make_torus(1, 0.1, 60, 24));
  const SurfaceProjector project = make_projector(*torus);
  const ModelEntity face = ModelFaceId(0);
  for (const Vec3& x : {Vec3{1.1, 0, 0}, Vec3{-1.1, 0, 0}, Vec3{-0.9, 0, 0}, Vec3{0, 1.1, 0}, Vec3{0, -1, 0.1}}) {
    const auto spot = project(face, x);
    REQUIRE(spot.has_value());
    CHECK(distance(spot->point, x) < 0.01);
  }
}

TEST_CASE("nested spheres are a solid with a void, whatever way they are turned; a third is a region again") {
  for (int turned = 0; turned < 8; ++turned) {
    INFO("turned " << turned);
    Facets facets;
    append(facets, make_sphere({0, 0, 0}, 1, 2), turned & 1);
    append(facets, make_sphere({0, 0, 0}, 3, 2), turned & 2);
    append(facets, make_sphere({0.2, 0, 0}, 2, 2), turned & 4);
    const auto model = model_of(facets);
    check_invariants(*model);
    const ModelTopology& topology = model->topology();
    REQUIRE(topology.region_count() == 2);
    const double unit = volume_of(make_sphere({0, 0, 0}, 1, 2));
    CHECK(model->volume(ModelRegionId(0)) == Approx(unit));
    CHECK(model->volume(ModelRegionId(1)) == Approx((27 - 8) * unit));
    CHECK(topology.region_to_faces[1] == std::vector<ModelFaceId>{ModelFaceId(1), ModelFaceId(2)});
    for (const FaceSides& sides : topology.face_to_sides) CHECK((sides.back.valid() && !sides.front.valid()));
  }
}

TEST_CASE("bodies side by side are regions of their own") {
  Facets facets;
  for (int i = 0; i < 5; ++i) append(facets, make_sphere({3.0 * i, 0.3 * i, 0}, 1, 1), i % 2);
  append(facets, make_box({-10, -10, 5}, {20, 10, 6}));
  const auto model = model_of(facets);
  check_invariants(*model);
  CHECK(model->topology().region_count() == 6);
}

TEST_CASE("an open sheet has edges, corners and no region; its orientation stays") {
  const Facets sheet = make_grid(
      6, 4, false,
      [](std::uint32_t i, std::uint32_t j) {
        return Vec3{1.0 * i, 1.0 * j, 0};
      },
      false);
  const auto model = model_of(sheet);
  check_invariants(*model);
  CHECK(model->topology().region_count() == 0);
  CHECK(model->topology().edge_count() == 4);
  CHECK(model->topology().vertex_count == 4);
  CHECK(model->face_geometry(ModelFaceId(0))->normal({0, 0}) == Vec3{0, 0, 1});
  CHECK(!model->topology().face_to_sides[0].back.valid());
  CHECK(!model->topology().face_to_sides[0].front.valid());
}

TEST_CASE("a sheet within a solid has the solid on both sides") {
  Facets facets = make_box({0, 0, 0}, {1, 1, 1}, 2);
  append(facets, make_grid(
                     2, 2, false,
                     [](std::uint32_t i, std::uint32_t j) {
                       return Vec3{0.3 + 0.2 * i, 0.3 + 0.2 * j, 0.5};
                     },
                     false));
  const auto model = model_of(facets);
  REQUIRE(model->topology().face_count() == 7);
  CHECK(model->topology().face_to_sides[6].front == ModelRegionId(0));
  CHECK(model->topology().face_to_sides[6].back == ModelRegionId(0));
  CHECK(model->volume(ModelRegionId(0)) == Approx(1));
}

TEST_CASE("two boxes that share a side share a face, and each is a region") {
  Facets facets = make_box({0, 0, 0}, {1, 1, 1}, 2);
  append(facets, make_box({1, 0, 0}, {3, 1, 1}, 2), GENERATE(false, true));
  const auto model = model_of(facets);
  check_invariants(*model);
  const ModelTopology& topology = model->topology();
  CHECK(topology.face_count() == 11);
  REQUIRE(topology.region_count() == 2);
  CHECK(model->volume(ModelRegionId(0)) == Approx(1));
  CHECK(model->volume(ModelRegionId(1)) == Approx(2));
  const auto shared = std::count_if(topology.face_to_sides.begin(), topology.face_to_sides.end(),
                                    [](const FaceSides& sides) { return sides.front.valid() && sides.back.valid(); });
  CHECK(shared == 1);
  CHECK(topology.region_to_faces[0].size() == 6);
  CHECK(topology.region_to_faces[1].size() == 6);
}

TEST_CASE("two boxes that touch in an edge only are two regions") {
  Facets facets = make_box({0, 0, 0}, {1, 1, 1}, 2);
  append(facets, make_box({1, 1, 0}, {2, 2, 1}, 2));
  const auto model = model_of(facets);
  check_invariants(*model);
  CHECK(model->topology().region_count() == 2);
  CHECK(model->topology().face_count() == 12);
  CHECK(model->topology().edge_count() == 23);
}

TEST_CASE("a fan of five sheets at one edge has a face each and no region") {
  Facets facets;
  facets.points = {{0, 0, 0}, {0, 0, 1}};
  for (int i = 0; i < 5; ++i) {
    const double angle = 1.1 * i;
    const auto first = static_cast<std::uint32_t>(facets.points.size());
    facets.points.push_back({std::cos(angle), std::sin(angle), 0});
    facets.points.push_back({std::cos(angle), std::sin(angle), 1});
    facets.triangles.push_back({0, first, first + 1});
    facets.triangles.push_back(i % 2 ? Triangle{0, first + 1, 1} : Triangle{1, first + 1, 0});
  }
  const auto model = model_of(facets);
  check_invariants(*model);
  CHECK(model->topology().face_count() == 5);
  CHECK(model->topology().edge_count() == 16);
  CHECK(model->topology().region_count() == 0);
}

TEST_CASE("a wall across a box makes two regions of it") {
  Facets facets = make_box({0, 0, 0}, {2, 1, 1}, 2);
  append(facets, make_grid(
                     2, 2, false,
                     [](std::uint32_t i, std::uint32_t j) {
                       return Vec3{1, 0.5 * i, 0.5 * j};
                     },
                     false));
  const auto model = model_of(facets);
  check_invariants(*model);
  REQUIRE(model->topology().region_count() == 2);
  CHECK(model->volume(ModelRegionId(0)) == Approx(1));
  CHECK(model->volume(ModelRegionId(1)) == Approx(1));
  CHECK(model->topology().face_count() == 11);
}

TEST_CASE("a fin on a box belongs to the outside on both sides") {
  Facets facets = make_box({0, 0, 0}, {2, 1, 1}, 2);
  append(facets, make_grid(
                     2, 2, false,
                     [](std::uint32_t i, std::uint32_t j) {
                       return Vec3{1, 0.5 * i, 1 + 0.5 * j};
                     },
                     false));
  const auto model = model_of(facets);
  check_invariants(*model);
  REQUIRE(model->topology().region_count() == 1);
  CHECK(model->volume(ModelRegionId(0)) == Approx(2));
  CHECK(model->topology().face_count() == 8);
}

TEST_CASE("a Möbius strip is cut open and meshes as a sheet") {
  // Twenty pieces around, the last joined to the first upside down.
  Facets strip;
  const std::uint32_t n = 40;
  for (std::uint32_t i = 0; i < n; ++i) {
    const double angle = 2 * M_PI * i / n;
    for (const double s : {-0.3, 0.3}) {
      const double rho = 1 + s * std::cos(angle / 2);
      strip.points.push_back({rho * std::cos(angle), rho * std::sin(angle), s * std::sin(angle / 2)});
    }
  }
  for (std::uint32_t i = 0; i < n; ++i) {
    const bool last = i + 1 == n;
    const std::uint32_t a = 2 * i, b = a + 1, c = last ? 1 : a + 2, d = last ? 0 : a + 3;
    strip.triangles.push_back({a, c, d});
    strip.triangles.push_back({a, d, b});
  }
  const auto model = model_of(strip);
  check_invariants(*model);
  CHECK(model->topology().region_count() == 0);
  REQUIRE(model->topology().face_count() == 1);
  std::size_t seconds = 0;
  for (const ModelLoop& loop : model->topology().face_to_loops[0]) {
    for (const EdgeUse& use : loop) seconds += use.second_side;
  }
  CHECK(seconds == 1);
}

TEST_CASE("a crease that fades out within a face is an edge that the face has twice") {
  // A sheet folded along x = 0, ever less with growing y.
  const Facets sheet = make_grid(
      8, 10, false,
      [](std::uint32_t i, std::uint32_t j) {
        const double x = static_cast<double>(i) - 4, fold = std::max(0.0, 1.2 - 0.2 * j);
        return Vec3{x, 1.0 * j, fold * std::abs(x)};
      },
      false);
  const auto model = model_of(sheet);
  check_invariants(*model);
  REQUIRE(model->topology().face_count() == 1);
  std::size_t uses = 0, seconds = 0;
  for (const ModelLoop& loop : model->topology().face_to_loops[0]) {
    for (const EdgeUse& use : loop) ++uses, seconds += use.second_side;
  }
  CHECK(seconds == 1);
  CHECK(uses == model->topology().edge_count() + 1);
}

TEST_CASE("noise does not cut a scan into faces, and the edges of a box with noise stay") {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> noise(-0.5, 0.5);
  Facets sphere = make_sphere({0, 0, 0}, 1, 6);  // edges of 0.02
  for (Vec3& p : sphere.points) p = (1 + 0.01 * noise(random)) * p;
  const auto scan = model_of(sphere);
  check_invariants(*scan);
  CHECK(scan->topology().face_count() <= 3);
  CHECK(scan->topology().region_count() == 1);
  Facets box = make_box({0, 0, 0}, {1, 1, 1}, 40);
  std::map<std::array<double, 3>, Vec3> moved;  // the sides have points of their own
  for (Vec3& p : box.points) {
    const auto [entry, is_new] = moved.try_emplace({p.x, p.y, p.z}, p);
    if (is_new) entry->second = p + 0.008 * Vec3{noise(random), noise(random), noise(random)};
    p = entry->second;
  }
  const auto rough = model_of(box);
  check_invariants(*rough);
  CHECK(rough->topology().face_count() == 6);
}

TEST_CASE("a model is the same whatever way it is made twice") {
  Facets facets = make_cylinder(1, 3, 24, 6);
  append(facets, make_sphere({0, 0, 1.5}, 0.4, 2));
  const auto a = model_of(facets), b = model_of(facets);
  CHECK(a->topology().face_to_loops.size() == b->topology().face_to_loops.size());
  for (std::size_t face = 0; face < a->topology().face_count(); ++face) {
    const auto ta = a->face_geometry(ModelFaceId(face))->tessellate(1, 1);
    const auto tb = b->face_geometry(ModelFaceId(face))->tessellate(1, 1);
    CHECK(ta.points == tb.points);
    CHECK(ta.tri_to_vert == tb.tri_to_vert);
  }
  CHECK(a->topology().region_count() == 1);
}

TEST_CASE("where a surface touches itself in a point, each side has an edge that begins there") {
  // A ring whose hole has shrunk to a point.
  Facets horn = make_torus(1, 1, 32, 24);
  for (Vec3& p : horn.points)
    if (std::hypot(p.x, p.y) < 1e-9) p = {0, 0, 0};
  const auto model = make_discrete_model(horn.points, horn.triangles, 40 * M_PI / 180);
  const ModelTopology& topology = model->topology();
  CHECK(topology.face_count() == 1);
  CHECK(topology.region_count() == 1);
  std::size_t at_point = 0;
  for (std::uint32_t v = 0; v < topology.vertex_count; ++v)
    if (model->vertex_point(ModelVertexId(v)) == Vec3{}) ++at_point;
  CHECK(at_point == 1);
  REQUIRE(topology.edge_count() == 2);
  for (const ModelEdgeTopology& edge : topology.edges) {
    const auto is_middle = [&](ModelVertexId v) { return model->vertex_point(v) == Vec3{}; };
    CHECK((is_middle(edge.vertices[0]) || is_middle(edge.vertices[1])));
  }
}
