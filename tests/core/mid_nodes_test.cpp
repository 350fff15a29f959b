// Meshes of second order: their edges and mid nodes, the Jacobian of curved tets, and what checks say of them.
#include <catch2/catch.hpp>
#include <cmath>
#include <random>
#include <set>

#include "core/mesh/curved_tet.hpp"
#include "core/mesh/mid_nodes.hpp"
#include "tests/support/block_loops.hpp"
#include "tests/support/error_of.hpp"
#include "tests/support/mixed_mesh.hpp"
#include "tests/support/second_order_mesh.hpp"
#include "tetloom/check.hpp"

using namespace tetloom;
using test::error_of;
using test::with_mid_nodes;

namespace {

const TetNodes kStraight{{{0, 0, 0},
                          {1, 0, 0},
                          {0, 1, 0},
                          {0, 0, 1},
                          {.5, 0, 0},
                          {.5, .5, 0},
                          {0, .5, 0},
                          {0, 0, .5},
                          {.5, 0, .5},
                          {0, .5, .5}}};

TetNodes displaced(unsigned seed, double by) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> any(-by, by);
  TetNodes nodes = kStraight;
  for (std::size_t i = 4; i < nodes.size(); ++i) nodes[i] += Vec3{any(random), any(random), any(random)};
  return nodes;
}

/// The Jacobian by the shape functions of the element at barycentric coordinates, over six volumes of the straight tet.
double sampled_jacobian(const TetNodes& nodes, const std::array<double, 4>& l) {
  constexpr std::array<Vec3, 4> kGradients{{{-1, -1, -1}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};
  std::array<Vec3, 3> columns{};  // of the derivatives by the three local coordinates
  const auto add = [&](const Vec3& node, const Vec3& gradient) {
    for (int i = 0; i < 3; ++i) columns[static_cast<std::size_t>(i)] += gradient[i] * node;
  };
  for (std::size_t v = 0; v < 4; ++v) add(nodes[v], (4 * l[v] - 1) * kGradients[v]);
  for (std::size_t e = 0; e < 6; ++e) {
    const auto [a, b] = shape_of(CellKind::Tet).edge[e];
    add(nodes[4 + e], 4 * l[a] * kGradients[b] + 4 * l[b] * kGradients[a]);
  }
  const double straight = dot(nodes[1] - nodes[0], cross(nodes[2] - nodes[0], nodes[3] - nodes[0]));
  return dot(columns[0], cross(columns[1], columns[2])) / straight;
}

double least_sampled(const TetNodes& nodes) {
  constexpr int kSteps = 12;
  double least = HUGE_VAL;
  for (int i = 0; i <= kSteps; ++i)
    for (int j = 0; i + j <= kSteps; ++j)
      for (int k = 0; i + j + k <= kSteps; ++k)
        least = std::min(least, sampled_jacobian(nodes, {i / 12.0, j / 12.0, k / 12.0, (kSteps - i - j - k) / 12.0}));
  return least;
}

Vec3 bulge(const Vec3& x) { return {0.05 * std::sin(3 * x.y), 0.04 * std::cos(2 * x.z), 0.05 * std::sin(x.x + x.y)}; }

}  // namespace

TEST_CASE("every edge of every element is there once, in order, whoever carries out the loop") {
  const Mesh mesh = test::make_mixed_box(3, 2, 4, 5, false);
  std::set<std::array<std::uint32_t, 2>> expected;
  for_each_edge_owner(mesh, [&](const auto& elements, std::span<const LocalEdge> edges) {
    for (const auto& v : elements)
      for (const auto& [a, b] : edges) expected.insert({std::min(v[a], v[b]), std::max(v[a], v[b])});
  });
  const auto edges = edges_of_elements(mesh);
  CHECK(std::equal(edges.begin(), edges.end(), expected.begin(), expected.end()));
  CHECK(edges == edges_of_elements(mesh, test::BackwardsLoop()));
}

TEST_CASE("mid nodes are found by both ends of their edge") {
  const Mesh mesh = with_mid_nodes(test::make_tet_box(2, 2, 2));
  const MidNodes mids(mesh);
  for (std::uint32_t m = 0; m < mesh.mid_to_vert.size(); ++m) {
    const auto [a, b] = mesh.mid_to_vert[m];
    CHECK((mids.find(a, b) == m && mids.find(b, a) == m));
    CHECK(mids.point(a, b) == vertex_count(mesh) + m);
  }
  CHECK(mids.find(0, 0) == kNone);
  CHECK(mids.find(0, static_cast<std::uint32_t>(vertex_count(mesh))) == kNone);
  CHECK(MidNodes(test::make_tet_box(1, 1, 1)).find(0, 1) == kNone);
}

TEST_CASE("mid nodes lie on the entity of lowest dimension at their edge") {
  const Mesh mesh = with_mid_nodes(test::make_tet_box(4, 2, 2, 0, true));
  const MidNodes mids(mesh);
  const auto entity = [&](std::uint32_t a, std::uint32_t b) { return mesh.point_to_entity[mids.point(a, b)]; };
  for (std::size_t e = 0; e < mesh.edge_to_vert.size(); ++e)
    CHECK(entity(mesh.edge_to_vert[e][0], mesh.edge_to_vert[e][1]) == ModelEntity(1, mesh.edge_to_entity[e]));
  std::size_t on_faces = 0, inside = 0;
  for (std::size_t m = vertex_count(mesh); m < mesh.points.size(); ++m) {
    REQUIRE(mesh.point_to_entity[m].valid());
    on_faces += mesh.point_to_entity[m].dim == 2;
    inside += mesh.point_to_entity[m].dim == 3;
  }
  CHECK(on_faces > 0);
  CHECK(inside + on_faces + mesh.edge_to_vert.size() == mesh.mid_to_vert.size());
}

TEST_CASE("mid nodes that are not as a mesh has them are refused with the reason") {
  const Mesh good = with_mid_nodes(test::make_tet_box(2, 1, 1));
  CHECK(validate_mesh(good).valid());
  const auto refuse = [](const Mesh& mesh, const std::string& reason) {
    const Diagnostic error = error_of([&] { require_consistent(mesh); });
    CHECK(error.code == ErrorCode::InvalidArgument);
    CHECK_THAT(error.message, Catch::Contains(reason));
    const ValidationReport report = validate_mesh(mesh);
    REQUIRE_FALSE(report.valid());
    CHECK(report.problems[0].kind == ProblemKind::ArrayLength);
  };
  Mesh bad = good;
  bad.mid_to_vert.resize(bad.points.size() + 1, {0, 1});
  refuse(bad, "more than");
  bad = good;
  std::swap(bad.mid_to_vert[0], bad.mid_to_vert[1]);
  refuse(bad, "ascending");
  bad = good;
  bad.mid_to_vert.back() = {0, static_cast<std::uint32_t>(bad.points.size() - 1)};
  refuse(bad, "no vertices");
  bad = good;
  bad.mid_to_vert.erase(bad.mid_to_vert.begin());
  refuse(bad, "no mid node");
}

TEST_CASE("a mesh without its mid nodes is the one of first order") {
  Mesh mesh = test::make_tet_box(2, 2, 1);
  Mesh curved = with_mid_nodes(mesh, bulge);
  curved.point_fields = {{"t", 2, std::vector<double>(2 * curved.points.size(), 1)}};
  drop_mid_nodes(curved);
  CHECK(mesh_digest(curved) == mesh_digest(mesh));
  CHECK(curved.point_fields[0].values.size() == 2 * mesh.points.size());
}

TEST_CASE("the coefficients give the Jacobian at the vertices, its mean and 1 for a straight tet") {
  for (const double c : tet_jacobian(kStraight)) CHECK(c == Approx(1));
  for (unsigned seed = 0; seed < 20; ++seed) {
    const TetNodes nodes = displaced(seed, 0.2);
    const TetJacobian jacobian = tet_jacobian(nodes);
    for (std::size_t v = 0; v < 4; ++v) {
      std::array<double, 4> l{};
      l[v] = 1;
      CHECK(jacobian[v] == Approx(sampled_jacobian(nodes, l)));
    }
    // Five points integrate cubics exactly.
    double mean = -0.8 * sampled_jacobian(nodes, {.25, .25, .25, .25});
    for (std::size_t v = 0; v < 4; ++v) {
      std::array<double, 4> l{1. / 6, 1. / 6, 1. / 6, 1. / 6};
      l[v] = 0.5;
      mean += 0.45 * sampled_jacobian(nodes, l);
    }
    CHECK(mean_jacobian(jacobian) == Approx(mean));
  }
}

TEST_CASE("the bound of the Jacobian is below what is sampled, and sharp") {
  int inverted = 0, valid = 0;
  for (unsigned seed = 0; seed < 300; ++seed) {
    const TetNodes nodes = displaced(seed, 0.02 + 0.001 * seed);
    const TetJacobian jacobian = tet_jacobian(nodes);
    const double sampled = least_sampled(nodes), bound = least_jacobian(jacobian, 2);
    CHECK(bound <= sampled + 1e-12);
    CHECK(bound >= sampled - 0.05);  // the samples are coarse
    CHECK(least_jacobian(jacobian, 0.1) <= sampled + 1e-12);
    CHECK((least_jacobian(jacobian, 0.1) >= 0.1) == (bound >= 0.1));
    (sampled > 0 ? valid : inverted)++;
  }
  CHECK(inverted > 50);
  CHECK(valid > 50);
}

TEST_CASE("a mid node changes the digest, and no numbering does") {
  const Mesh mesh = with_mid_nodes(test::make_tet_box(2, 1, 1), bulge);
  const std::string digest = mesh_digest(mesh);
  Mesh straight = mesh;
  drop_mid_nodes(straight);
  CHECK(mesh_digest(straight) != digest);
  Mesh moved = mesh;
  moved.points.back().x += 1e-9;
  CHECK(mesh_digest(moved) != digest);
  Mesh exchanged = mesh;  // each of two mid nodes on the edge of the other one
  std::swap(exchanged.points[vertex_count(mesh)], exchanged.points.back());
  std::swap(exchanged.point_to_entity[vertex_count(mesh)], exchanged.point_to_entity.back());
  CHECK(mesh_digest(exchanged) != digest);
  CHECK(mesh_digest(mesh, test::BackwardsLoop()) == digest);
}

TEST_CASE("curved tets are measured, and inverted ones are a problem of the mesh") {
  Mesh mesh = with_mid_nodes(test::make_tet_box(2, 2, 2), bulge);
  CHECK(validate_mesh(mesh).valid());
  QualityReport quality = compute_quality(mesh);
  CHECK(quality.curved.count == mesh.tet_to_vert.size());
  CHECK(quality.curved.not_positive == 0);
  CHECK(quality.curved.min_scaled_jacobian < 1);
  CHECK(quality.curved.min_scaled_jacobian > 0.2);
  CHECK(quality.cells.volume == Approx(8));
  CHECK(quality.curved.volume != Approx(8).epsilon(1e-4));

  const std::uint32_t mid = CellMids(CellKind::Tet, mesh.tet_to_vert[3], MidNodes(mesh))[0];
  mesh.points[vertex_count(mesh) + mid] += Vec3{0.6, 0.7, 0.8};
  quality = compute_quality(mesh);
  CHECK(quality.curved.not_positive > 0);
  CHECK(quality.curved.min_scaled_jacobian < 0);
  const ValidationReport report = validate_mesh(mesh);
  REQUIRE(report.problems.size() == 1);
  CHECK(report.problems[0].kind == ProblemKind::NonPositiveJacobian);
  CHECK(report.problems[0].count == quality.curved.not_positive);

  const QualityReport straight = compute_quality(with_mid_nodes(test::make_tet_box(2, 2, 2)));
  CHECK(straight.curved.count == 0);
  CHECK(straight.curved.min_scaled_jacobian == 1);
  CHECK(straight.curved.volume == Approx(8));
}
