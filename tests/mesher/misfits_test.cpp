// What is too narrow for its sizes: single triangles, and what refinement there does for the smallest angle.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>

#include "mesher/sizing/misfits.hpp"
#include "tests/mesher/options_of_size.hpp"
#include "tests/support/analytic_model.hpp"
#include "tetloom/check.hpp"
#include "tetloom/mesh.hpp"
#include "tetloom/tasks.hpp"

using namespace tetloom;
using namespace tetloom::test_models;

namespace {

/// A sheet between two model edges that meet at both ends: edge 0 along the x axis, edge 1 through `heights` above
/// x = 1, 2, …
///
///        __.--4--.__        one triangle between each piece of an edge and a point of the other one
///     _.3     |     5._
///    0-----1-----2-----…
struct Lens {
  Mesh mesh;
  ModelTopology topology;
  explicit Lens(const std::vector<double>& heights) {
    const auto count = static_cast<std::uint32_t>(heights.size());
    const auto low = [&](std::uint32_t i) { return i; };
    const auto high = [&](std::uint32_t i) { return i == 0 ? 0 : i == count + 1 ? count + 1 : count + 1 + i; };
    for (std::uint32_t i = 0; i <= count + 1; ++i) add_point({double(i), 0, 0}, ModelEdgeId(0));
    for (std::uint32_t i = 1; i <= count; ++i) add_point({double(i), heights[i - 1], 0}, ModelEdgeId(1));
    mesh.point_to_entity[0] = ModelVertexId(0);
    mesh.point_to_entity[count + 1] = ModelVertexId(1);
    for (std::uint32_t i = 0; i <= count; ++i) {
      if (i > 0) add_triangle({low(i), low(i + 1), high(i)});
      if (i < count) add_triangle({low(i + 1), high(i + 1), high(i)});
      add_piece(low(i), low(i + 1), 0);
      add_piece(high(i), high(i + 1), 1);
    }
    mesh.face_to_sides.resize(1);
    topology.vertex_count = 2;
    topology.edges.resize(2);
    for (ModelEdgeTopology& edge : topology.edges) edge.vertices = {ModelVertexId(0), ModelVertexId(1)};
    topology.face_to_loops = {{{{ModelEdgeId(0)}, {ModelEdgeId(1)}}}};
    topology.face_to_sides.resize(1);
  }

  std::vector<Misfit> misfits(bool has_layers = false) const {
    const TaskRunner runner(1);
    const intersection::TriangleTree tree(mesh.points, mesh.tri_to_vert, runner);
    const auto floor = [](const Vec3&) { return SizeFloor{0.5, 0.01}; };
    const std::vector<std::uint8_t> face_has_layers(1, has_layers ? 1 : 0);
    return find_misfits(mesh, topology, SizeField::uniform(1), floor, tree, SharedWork(runner), {}, face_has_layers);
  }

 private:
  void add_point(const Vec3& x, ModelEntity entity) {
    mesh.points.push_back(x);
    mesh.point_to_entity.push_back(entity);
  }
  void add_triangle(const std::array<std::uint32_t, 3>& verts) {
    mesh.tri_to_vert.push_back(verts);
    mesh.tri_to_entity.push_back(0);
  }
  void add_piece(std::uint32_t a, std::uint32_t b, std::uint32_t edge) {
    mesh.edge_to_vert.push_back({a, b});
    mesh.edge_to_entity.push_back(edge);
  }
};

/// A block with a void in it, a bar along x of three sides, an edge of which is this far above the bottom; at its other
/// end by `rise` more.
std::unique_ptr<GeometricModel> make_block_with_bar(double gap, double rise = 0) {
  std::vector<Vec3> points{{0, 0, 0},       {3, 0, 0},       {3, 3, 0},       {0, 3, 0},       {0, 0, 2},
                           {3, 0, 2},       {3, 3, 2},       {0, 3, 2},       {1.2, 1.5, gap}, {1.2, 1.1, 0.6},
                           {1.2, 1.9, 0.6}, {1.8, 1.5, gap}, {1.8, 1.1, 0.6}, {1.8, 1.9, 0.6}};
  const std::vector<std::vector<std::uint32_t>> faces{{0, 3, 2, 1},   {4, 5, 6, 7},    {0, 1, 5, 4},   {1, 2, 6, 5},
                                                      {2, 3, 7, 6},   {3, 0, 4, 7},    {8, 10, 9},     {11, 12, 13},
                                                      {8, 9, 12, 11}, {9, 10, 13, 12}, {10, 8, 11, 13}};
  for (std::size_t v = 11; v < points.size(); ++v) points[v].z += rise;
  return make_polyhedron(points, faces);
}

}  // namespace

TEST_CASE("a face that narrows between two edges up to where they meet is no misfit") {
  CHECK(Lens({0.1, 0.2, 0.2, 0.1}).misfits().empty());
  CHECK(Lens({0.05, 0.02, 0.02, 0.02, 0.05}).misfits().empty());
}

TEST_CASE("the ends of a narrow face of which only they were eliminated are refined") {
  Lens lens({0.05, 0.05, 0.05, 0.05});
  lens.topology.vertex_count = 4;
  lens.topology.edges[1].vertices = {ModelVertexId(2), ModelVertexId(3)};
  const std::vector<Misfit> found = lens.misfits();
  const auto is_told = [&](std::uint32_t triangle) {
    return std::ranges::any_of(found, [&](const Misfit& misfit) {
      return misfit.triangle == triangle && misfit.size == Approx(0.05 / 0.2).epsilon(0.01);
    });
  };
  CHECK(is_told(0));
  CHECK(is_told(static_cast<std::uint32_t>(lens.mesh.tri_to_vert.size() - 1)));
}

TEST_CASE("what is a tenth of its size gets a smaller one than what is a little narrower than it should be") {
  Lens lens({0.7, 0.02, 0.02, 0.02, 0.02, 0.7});
  const std::vector<Misfit> found = lens.misfits();
  REQUIRE_FALSE(found.empty());
  const auto is_eased = [](const Misfit& misfit) { return misfit.size == Approx(0.02 / 0.2).epsilon(0.01); };
  CHECK(std::ranges::count_if(found, is_eased) >= 5);
  CHECK_FALSE(are_negligible(found, lens.mesh, SizeField::uniform(1), found.size() + 1));
  // Half of the size would do, and they are few.
  Mesh large = lens.mesh;
  large.tri_to_vert.resize(2000, large.tri_to_vert[0]);
  CHECK(are_negligible({{0, 0.8}}, large, SizeField::uniform(1), 2));
  CHECK_FALSE(are_negligible({{0, 0.3}}, large, SizeField::uniform(1), 2));
  // As many as before smaller sizes were made.
  CHECK(are_negligible({{0, 0.3}}, large, SizeField::uniform(1), 1));
  CHECK_FALSE(are_negligible(found, lens.mesh, SizeField::uniform(1), 1));
}

TEST_CASE("below layers a strip has edges that give their cells good shapes, also below the usual floor") {
  for (const double width : {0.36, 0.2}) {
    CAPTURE(width);
    const Lens lens({0.7, width, width, width, width, 0.7});
    if (width > 0.3) CHECK(lens.misfits().empty());
    const auto fits = [&](const Misfit& misfit) {
      return misfit.size == Approx(width / std::hypot(1, width) / 0.55).epsilon(0.02);
    };
    CHECK(std::ranges::count_if(lens.misfits(), fits) == 0);
    CHECK(std::ranges::count_if(lens.misfits(true), fits) >= 5);
  }
  CHECK(Lens({0.1, 0.2, 0.2, 0.1}).misfits(true).empty());
}

TEST_CASE("layers on a solid with a narrow face have cells of good shapes there") {
  const auto cube = make_chamfered_cube(0.09);
  MeshOptions options = options_of_size(0.3);
  for (std::uint32_t face = 0; face < cube->topology().face_count(); ++face) {
    WallLayers wall;
    wall.face = ModelFaceId(face);
    wall.first_height = 0.005, wall.count = 3;
    options.layers.walls.push_back(wall);
  }
  const MeshResult result = make_mesh(*cube, options);
  REQUIRE(result.status == MeshStatus::Ok);
  constexpr std::uint32_t kChamfer = 4;
  std::size_t on_chamfer = 0;
  for (std::size_t t = 0; t < result.mesh.tri_to_vert.size(); ++t) {
    if (result.mesh.tri_to_entity[t] != kChamfer) continue;
    ++on_chamfer;
    const auto& [a, b, c] = result.mesh.tri_to_vert[t];
    const Vec3 &x = result.mesh.points[a], &y = result.mesh.points[b], &z = result.mesh.points[c];
    for (const auto& [at, left, right] : {std::array{x, y, z}, std::array{y, z, x}, std::array{z, x, y}})
      CHECK(norm(cross(left - at, right - at)) > std::tan(std::numbers::pi / 9) * dot(left - at, right - at));
  }
  CHECK(on_chamfer > 0);
}

TEST_CASE("a wall that is narrow below an edge alone is refined there") {
  for (const double gap : {0.02, 0.006}) {
    INFO("gap " << gap);
    MeshOptions options;
    options.sizes.size = 0.2;
    options.threads = 2;
    const MeshResult made = make_mesh(*make_block_with_bar(gap), options);
    REQUIRE(made.status == MeshStatus::Ok);
    CHECK(validate_mesh(made.mesh).problems.empty());
    CHECK(compute_quality(made.mesh, &made.sizes).tets.min_dihedral_deg >= 5);
  }
}

TEST_CASE("walls that touch are not refined where they do: every size finds them as narrow again") {
  MeshOptions options;
  options.sizes.size = 0.2;
  options.threads = 2;
  options.refine_surface = false;
  const auto model = make_block_with_bar(1e-6, 0.06);
  const MeshResult coarse = make_mesh(*model, options);
  options.refine_surface = true;
  const MeshResult made = make_mesh(*model, options);
  for (const MeshResult* result : {&coarse, &made}) {
    REQUIRE(result->status == MeshStatus::Ok);
    CHECK(validate_mesh(result->mesh).problems.empty());
  }
  CHECK(made.mesh.tet_to_vert.size() <= 1.1 * coarse.mesh.tet_to_vert.size());
  // A warning of what was made smaller says nothing of what was taken back.
  const auto is_reduced = [](const Diagnostic& warning) { return warning.code == ErrorCode::SizeReduced; };
  CHECK((made.refinement.narrow_places > 0) == std::ranges::any_of(made.warnings, is_reduced));
  CHECK((made.refinement.smallest_size > 0) == (made.refinement.narrow_places + made.refinement.crossings > 0));
}

TEST_CASE("a wall that is somewhat narrow below an edge alone is refined there too") {
  MeshOptions options;
  options.sizes.size = 0.2;
  options.threads = 2;
  const MeshResult made = make_mesh(*make_block_with_bar(0.03), options);
  REQUIRE(made.status == MeshStatus::Ok);
  CHECK(made.refinement.narrow_places > 0);
  CHECK(compute_quality(made.mesh, &made.sizes).tets.min_dihedral_deg >= 12);
}

TEST_CASE("what forces small angles in a narrow region is named, with its width") {
  MeshOptions options;
  options.sizes.size = 0.2;
  options.threads = 2;
  options.refine_surface = false;
  for (const double gap : {0.02, 0.006}) {
    INFO("gap " << gap);
    const MeshResult made = make_mesh(*make_block_with_bar(gap), options);
    REQUIRE(made.status == MeshStatus::Ok);
    const tets::OptimizeReport& report = made.filling.optimizer;
    REQUIRE_FALSE(report.acute_tets.empty());
    CHECK(report.forced == report.below_dihedral);
    CHECK(report.forced == report.forced_by_angles + report.forced_by_triangles + report.forced_by_points);
    for (const AcuteTet& tet : report.acute_tets) {
      CHECK(tet.cause_angle > 0);
      CHECK_FALSE(tet.entities.empty());
      if (tet.cause == AngleCause::NarrowRegion) CHECK(tet.cause_length >= 0.999 * gap);
    }
    CHECK(std::ranges::count(report.acute_tets, AngleCause::NarrowRegion, &AcuteTet::cause) > 0);
  }
}

TEST_CASE("a wall of one layer is named with its width, not with the distance of points askew on its two sides") {
  constexpr double kThick = 0.01;
  const std::vector<Vec3> points{{0, 0, 0},      {1.3, 0, 0},      {1.3, 1, 0},      {0, 1, 0},
                                 {0, 0, kThick}, {1.3, 0, kThick}, {1.3, 1, kThick}, {0, 1, kThick}};
  const std::vector<std::vector<std::uint32_t>> faces{{0, 3, 2, 1}, {4, 5, 6, 7}, {0, 1, 5, 4},
                                                      {1, 2, 6, 5}, {2, 3, 7, 6}, {3, 0, 4, 7}};
  MeshOptions options;
  options.sizes.size = 0.1;
  options.threads = 2;
  options.refine_surface = false;
  const MeshResult made = make_mesh(*make_polyhedron(points, faces), options);
  REQUIRE(made.status == MeshStatus::Ok);
  int narrow = 0;
  for (const AcuteTet& tet : made.filling.optimizer.acute_tets) {
    if (tet.cause != AngleCause::NarrowRegion) continue;
    ++narrow;
    CHECK(tet.cause_length <= 1.01 * kThick);
    CHECK(std::ranges::any_of(tet.entities, [](const NamedEntity& one) { return one.entity.dim == 2; }));
  }
  CHECK(narrow > 20);
}
