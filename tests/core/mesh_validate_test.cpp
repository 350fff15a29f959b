#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <iostream>
#include <limits>

#include "tests/core/mesh_fixtures.hpp"
#include "tetloom/check.hpp"

using namespace tetloom;

namespace {

const MeshProblem* find(const ValidationReport& report, ProblemKind kind) {
  for (const MeshProblem& problem : report.problems)
    if (problem.kind == kind) return &problem;
  return nullptr;
}

std::string kinds(const ValidationReport& report) {
  std::string text;
  for (const MeshProblem& problem : report.problems) text += std::string(to_string(problem.kind)) + " ";
  return text;
}

/// The report on a box of two regions after `change`.
template <class Change>
ValidationReport after(const Change& change) {
  Mesh mesh = test::make_box(4, 3, 3, true);
  change(mesh);
  return validate_mesh(mesh);
}

template <class Change>
std::string kinds_after(const Change& change) {
  return kinds(after(change));
}

template <class Array>
void drop_first(Array& array) {
  array.erase(array.begin());
}

void drop_triangle(Mesh& mesh, std::size_t t) {
  mesh.tri_to_vert.erase(mesh.tri_to_vert.begin() + static_cast<std::ptrdiff_t>(t));
  mesh.tri_to_entity.erase(mesh.tri_to_entity.begin() + static_cast<std::ptrdiff_t>(t));
}

/// The first triangle with a region on its front and its back, or on one of them only.
std::size_t find_triangle(const Mesh& mesh, bool internal) {
  for (std::size_t t = 0; t < mesh.tri_to_entity.size(); ++t) {
    const FaceSides& sides = mesh.face_to_sides[mesh.tri_to_entity[t]];
    if ((sides.front.valid() && sides.back.valid()) == internal) return t;
  }
  return mesh.tri_to_entity.size();
}

}  // namespace

TEST_CASE("a box of two regions is valid, with what was seen on the way") {
  Mesh mesh = test::make_box(4, 3, 2, true);
  test::decorate(mesh);
  const ValidationReport report = validate_mesh(mesh);
  CHECK(kinds(report) == "");
  CHECK(report.valid());
  CHECK(report.boundary_faces == 2 * 2 * (4 * 3 + 4 * 2 + 3 * 2));
  CHECK(report.interface_faces == 2 * 3 * 2);
  CHECK(report.open_edges == 0);
  CHECK(report.nonmanifold_edges == 0);
  CHECK(report.unused_points == 0);
  CHECK(report.unclassified_points == 0);
}

TEST_CASE("an empty mesh is valid") { CHECK(validate_mesh(Mesh{}).valid()); }

TEST_CASE("tets alone, without triangles and classification, are valid") {
  Mesh mesh;
  const Mesh box = test::make_box(3, 3, 3);
  mesh.points = box.points;
  mesh.tet_to_vert = box.tet_to_vert;
  mesh.tet_to_entity.assign(mesh.tet_to_vert.size(), ModelRegionId::kNone);
  const ValidationReport report = validate_mesh(mesh);
  CHECK(kinds(report) == "");
  CHECK(report.unclassified_points == mesh.points.size());
}

TEST_CASE("an open surface is reported and is no problem") {
  Mesh mesh = test::make_box(3, 3, 3);
  mesh.tet_to_vert.clear();
  mesh.tet_to_entity.clear();
  ValidationReport report = validate_mesh(mesh);
  CHECK(kinds(report) == "");
  CHECK(report.open_edges == 0);
  CHECK(report.unused_points == 2 * 2 * 2);
  drop_triangle(mesh, 5);
  report = validate_mesh(mesh);
  CHECK(kinds(report) == "");
  CHECK(report.open_edges == 3);
}

TEST_CASE("arrays of the wrong length and indices out of range are named and end the check") {
  CHECK(kinds_after([](Mesh& m) { drop_first(m.tet_to_entity); }) == "array_length ");
  CHECK(kinds_after([](Mesh& m) { drop_first(m.point_to_entity); }) == "array_length ");
  CHECK(kinds_after([](Mesh& m) { drop_first(m.tri_to_vert); }) == "array_length ");
  const ValidationReport report = after([](Mesh& m) { m.tet_to_vert[7][2] = 1u << 31; });
  REQUIRE(kinds(report) == "index_out_of_range ");
  CHECK(report.problems[0].elements == std::vector<std::uint64_t>{7});
  CHECK(report.problems[0].message == "tets that refer to points that are not there: 1");
}

TEST_CASE("points that are not finite are named, with the tets around them") {
  const ValidationReport report = after([](Mesh& m) { m.points[30].y = std::numeric_limits<double>::quiet_NaN(); });
  REQUIRE(find(report, ProblemKind::NonFinitePoint) != nullptr);
  CHECK(find(report, ProblemKind::NonFinitePoint)->elements == std::vector<std::uint64_t>{30});
  CHECK(find(report, ProblemKind::NonPositiveVolume) != nullptr);
}

TEST_CASE("inverted and exactly flat tets are found, barely positive ones are not") {
  Mesh mesh;
  mesh.points = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0.3, 0.3, 5e-324}};
  mesh.point_to_entity.resize(4);
  mesh.tet_to_vert = {{0, 1, 2, 3}};
  mesh.tet_to_entity = {0};
  CHECK(validate_mesh(mesh).valid());
  mesh.points[3].z = 0;
  CHECK(kinds(validate_mesh(mesh)) == "non_positive_volume ");
  mesh.points[3].z = -1;
  CHECK(kinds(validate_mesh(mesh)) == "non_positive_volume ");
  REQUIRE(validate_mesh(mesh).problems[0].point.has_value());
  CHECK(validate_mesh(mesh).problems[0].point->z == -0.25);
}

TEST_CASE("repeated vertices are found in every kind of element") {
  CHECK(find(after([](Mesh& m) { m.tet_to_vert[3][1] = m.tet_to_vert[3][0]; }), ProblemKind::RepeatedVertex));
  CHECK(find(after([](Mesh& m) { m.tri_to_vert[3][1] = m.tri_to_vert[3][0]; }), ProblemKind::RepeatedVertex));
  CHECK(find(after([](Mesh& m) { m.edge_to_vert[3][1] = m.edge_to_vert[3][0]; }), ProblemKind::RepeatedVertex));
}

TEST_CASE("duplicate elements are counted once each") {
  ValidationReport report = after([](Mesh& m) {
    const auto tet = m.tet_to_vert[50];
    m.tet_to_vert.push_back({tet[1], tet[2], tet[0], tet[3]});
    m.tet_to_entity.push_back(m.tet_to_entity[50]);
  });
  REQUIRE(find(report, ProblemKind::DuplicateElement) != nullptr);
  CHECK(find(report, ProblemKind::DuplicateElement)->count == 1);
  CHECK(find(report, ProblemKind::FaceUsedTooOften) != nullptr);
  report = after([](Mesh& m) { m.tri_to_vert.push_back(m.tri_to_vert[9]), m.tri_to_entity.push_back(0); });
  REQUIRE(find(report, ProblemKind::DuplicateElement) != nullptr);
  CHECK(find(report, ProblemKind::DuplicateElement)->element == ElementKind::Triangle);
  CHECK(find(report, ProblemKind::DuplicateElement)->count == 1);
  report = after([](Mesh& m) {
    m.edge_to_vert.push_back({m.edge_to_vert[2][1], m.edge_to_vert[2][0]});
    m.edge_to_entity.push_back(m.edge_to_entity[2]);
  });
  CHECK(kinds(report) == "duplicate_element ");
}

TEST_CASE("very many copies of one tet are found in reasonable time") {
  Mesh mesh = test::make_box(1, 1, 1);
  mesh.tet_to_vert.assign(100000, mesh.tet_to_vert[0]);
  mesh.tet_to_entity.assign(100000, 0);
  const ValidationReport report = validate_mesh(mesh);
  REQUIRE(find(report, ProblemKind::DuplicateElement) != nullptr);
  CHECK(find(report, ProblemKind::DuplicateElement)->count == 99999);
  CHECK(find(report, ProblemKind::DuplicateElement)->elements.size() <= 8);
}

TEST_CASE("three tets at a face, and two on the same side of it, are found") {
  Mesh mesh;
  mesh.points = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0.2, 0.2, 1}, {0.2, 0.2, -1}, {0.3, 0.3, 2}};
  mesh.point_to_entity.resize(6);
  mesh.tet_to_vert = {{0, 1, 2, 3}, {0, 2, 1, 4}};
  mesh.tet_to_entity = {0, 0};
  CHECK(validate_mesh(mesh).valid());
  mesh.tet_to_vert = {{0, 1, 2, 3}, {0, 1, 2, 5}};
  CHECK(kinds(validate_mesh(mesh)) == "overlapping_tets ");
  mesh.tet_to_vert = {{0, 1, 2, 3}, {0, 2, 1, 4}, {0, 1, 2, 5}};
  mesh.tet_to_entity = {0, 0, 0};
  const ValidationReport report = validate_mesh(mesh);
  CHECK(kinds(report) == "face_used_too_often open_boundary ");
  CHECK(report.open_edges == 3);
}

TEST_CASE("boundary faces and interfaces without their triangle are found") {
  ValidationReport report = after([](Mesh& m) { drop_triangle(m, find_triangle(m, false)); });
  CHECK(kinds(report) == "boundary_without_triangle ");
  CHECK(report.problems[0].message == "boundary faces of tets without a triangle: 1");
  report = after([](Mesh& m) { drop_triangle(m, find_triangle(m, true)); });
  CHECK(kinds(report) == "interface_without_triangle ");
}

TEST_CASE("a triangle that is no face of a tet is found, unless its face is a sheet") {
  const auto add_loose_triangle = [](Mesh& m, std::uint32_t face) {
    const auto base = static_cast<std::uint32_t>(m.points.size());
    for (const double y : {0.0, 1.0}) m.points.push_back({50, y, 0});
    m.points.push_back({50, 0, 1});
    m.point_to_entity.resize(base + 3, ModelEntity(2, face));
    m.tri_to_vert.push_back({base, base + 1, base + 2});
    m.tri_to_entity.push_back(face);
  };
  CHECK(kinds_after([&](Mesh& m) { add_loose_triangle(m, 0); }) == "triangle_not_on_tets ");
  CHECK(kinds_after([&](Mesh& m) {
          m.face_to_sides.emplace_back();
          add_loose_triangle(m, static_cast<std::uint32_t>(m.face_to_sides.size() - 1));
        }) == "");
  CHECK(kinds_after([&](Mesh& m) {
          m.face_to_sides.clear();
          add_loose_triangle(m, 0);
        }) == "triangle_not_on_tets ");
}

TEST_CASE("a hole in the tets is found at the triangles") {
  const ValidationReport report = after([](Mesh& m) { drop_first(m.tet_to_vert), drop_first(m.tet_to_entity); });
  CHECK(find(report, ProblemKind::BoundaryWithoutTriangle) != nullptr);
  CHECK(find(report, ProblemKind::TriangleNotOnTets) != nullptr);
}

TEST_CASE("regions that are not those of the model face are found") {
  const ValidationReport report = after([](Mesh& m) {
    const std::uint32_t face = m.tri_to_entity[find_triangle(m, true)];
    std::swap(m.face_to_sides[face].front, m.face_to_sides[face].back);
  });
  CHECK(kinds(report) == "sides_disagree ");
  CHECK(report.problems[0].count == 2 * 3 * 3);
}

TEST_CASE("a triangle turned against its neighbours is found") {
  const auto turn = [](Mesh& m) { std::swap(m.tri_to_vert[0][0], m.tri_to_vert[0][1]); };
  CHECK(find(after(turn), ProblemKind::FlippedTriangle) != nullptr);
  CHECK(find(after(turn), ProblemKind::SidesDisagree) != nullptr);
}

TEST_CASE("faces that meet without a mesh edge, and edges off the triangles, are found") {
  CHECK(kinds_after([](Mesh& m) { drop_first(m.edge_to_vert), drop_first(m.edge_to_entity); }) == "missing_edge ");
  CHECK(kinds_after([](Mesh& m) { m.edge_to_vert.clear(), m.edge_to_entity.clear(); }) == "");
  const ValidationReport report = after([](Mesh& m) {
    m.edge_to_vert.push_back({m.edge_to_vert.front()[0], m.edge_to_vert.back()[1]});
    m.edge_to_entity.push_back(0);
  });
  CHECK(find(report, ProblemKind::EdgeNotOnTriangles) != nullptr);
}

TEST_CASE("contradictions in the classification are found on every kind of element") {
  const auto kind_of = [](const auto& change) {
    const ValidationReport report = after(change);
    const MeshProblem* problem = find(report, ProblemKind::ClassificationConflict);
    return problem == nullptr ? std::string("none") : std::string(to_string(problem->element));
  };
  const auto point_of_dim = [](const Mesh& m, int dim) {
    return std::find_if(m.point_to_entity.begin(), m.point_to_entity.end(),
                        [&](const ModelEntity& e) { return e.dim == dim; }) -
           m.point_to_entity.begin();
  };
  CHECK(kind_of([](Mesh&) {}) == "none");
  CHECK(kind_of([&](Mesh& m) { m.point_to_entity[point_of_dim(m, 1)].index ^= 1; }) == "edge");
  CHECK(kind_of([&](Mesh& m) { m.point_to_entity[point_of_dim(m, 2)].index ^= 1; }) == "triangle");
  CHECK(kind_of([&](Mesh& m) { m.point_to_entity[point_of_dim(m, 2)] = ModelEntity(3, 0); }) == "triangle");
  CHECK(kind_of([&](Mesh& m) { m.point_to_entity[point_of_dim(m, 3)].index ^= 1; }) == "tet");
  CHECK(kind_of([&](Mesh& m) { m.point_to_entity[point_of_dim(m, 3)] = ModelEntity(2, 0); }) == "point");
  CHECK(kind_of([&](Mesh& m) { m.point_to_entity[point_of_dim(m, 2)] = ModelEntity(1, 0); }) == "point");
}

TEST_CASE("entities beyond the mesh's own tables and gaps in the classification are found") {
  CHECK(kinds_after([](Mesh& m) { m.face_to_sides.pop_back(); }) == "entity_out_of_range ");
  CHECK(kinds_after([](Mesh& m) {
          test::decorate(m);
          m.entities[0].resize(3);
        }) == "entity_out_of_range ");
  CHECK(find(after([](Mesh& m) { m.tet_to_entity[0] = ModelRegionId::kNone; }), ProblemKind::PartlyClassified));
}

TEST_CASE("many problems are listed by the first few, with the full count") {
  const ValidationReport report = after([](Mesh& m) {
    for (auto& tet : m.tet_to_vert) std::swap(tet[0], tet[1]);
  });
  const MeshProblem* problem = find(report, ProblemKind::NonPositiveVolume);
  REQUIRE(problem != nullptr);
  CHECK(problem->count == 4 * 3 * 3 * 6);
  CHECK(problem->elements == std::vector<std::uint64_t>{0, 1, 2, 3, 4, 5, 6, 7});
}
