#include <catch2/catch.hpp>
#include <set>

#include "core/mesh/mesh_access.hpp"
#include "core/mesh/validate.hpp"
#include "tests/support/mixed_mesh.hpp"

using namespace tetloom;

namespace {

std::string messages(const ValidationReport& report) {
  std::string text;
  for (const MeshProblem& problem : report.problems) text += problem.message + "; ";
  return text;
}

/// How many model entities of a dimension the points of a mesh lie on.
std::size_t entities_of(const Mesh& mesh, int dim) {
  std::set<std::uint32_t> seen;
  for (const ModelEntity& entity : mesh.point_to_entity)
    if (entity.dim == dim) seen.insert(entity.index);
  return seen.size();
}

}  // namespace

TEST_CASE("a box of tets is valid and lies on the model of a box") {
  for (unsigned seed = 0; seed < 5; ++seed) {
    INFO("seed " << seed);
    const Mesh one = test::make_tet_box(3, 4, 5, seed), two = test::make_tet_box(4, 3, 3, seed, true);
    CHECK(messages(validate_mesh(one)) == "");
    CHECK(messages(validate_mesh(two)) == "");
    CHECK(validate_mesh(two).interface_faces == 2 * 3 * 3);
    CHECK(std::array{entities_of(one, 0), entities_of(one, 1), entities_of(one, 2)} ==
          std::array<std::size_t, 3>{8, 12, 6});
    CHECK(std::array{entities_of(two, 0), entities_of(two, 1), entities_of(two, 2)} ==
          std::array<std::size_t, 3>{12, 20, 11});
  }
}

TEST_CASE("a box of all kinds of cells is valid, whether its points are moved or not") {
  for (unsigned seed = 0; seed < 8; ++seed) {
    INFO("seed " << seed);
    for (const bool two_regions : {false, true}) {
      const Mesh mesh = test::make_mixed_box(4, 3, 6, seed, two_regions);
      CHECK(messages(validate_mesh(mesh)) == "");
      for (const CellKind kind : kAllCellKinds) CHECK(cell_count(mesh, kind) > 0);
      CHECK(mesh.quad_to_vert.size() > 0);
      CHECK(entities_of(mesh, 0) == (two_regions ? 12 : 8));
      CHECK(validate_mesh(mesh).boundary_faces == surface_count(mesh) - validate_mesh(mesh).interface_faces);
    }
  }
}

TEST_CASE("an inverted corner of any kind of cell is found") {
  const Mesh mesh = test::make_mixed_box(3, 3, 4);
  const auto turned = [&](CellKind kind) {
    Mesh other = mesh;
    for_each_cell_kind(other, [&](CellKind k, auto& cells, auto&) {
      if (k == kind) std::swap(cells[2][0], cells[2][1]);
    });
    for (const MeshProblem& problem : validate_mesh(other).problems)
      if (problem.kind == ProblemKind::NonPositiveVolume)
        return std::string(to_string(problem.element)) + " " + std::to_string(problem.elements[0]);
    return std::string();
  };
  for (const CellKind kind : kAllCellKinds) CHECK(turned(kind) == std::string(to_string(kind)) + " 2");
}

TEST_CASE("a hex with a corner pushed in is found although its volume is positive") {
  Mesh mesh;
  for (int i = 0; i < 8; ++i) mesh.points.push_back({(i ^ (i >> 1)) & 1 ? 1. : 0., i & 2 ? 1. : 0., i & 4 ? 1. : 0.});
  mesh.hex_to_vert = {{0, 1, 2, 3, 4, 5, 6, 7}};
  mesh.hex_to_entity = {0};
  CHECK(messages(validate_mesh(mesh)) == "");
  mesh.points[6] = {0.3, 0.3, 0.3};
  CHECK(messages(validate_mesh(mesh)) == "hexes that are flat or inverted: 1; ");
}

TEST_CASE("duplicates of any kind of cell and of quadrilaterals are counted once each, turned over or not") {
  const Mesh mesh = test::make_mixed_box(3, 3, 4);
  const auto count = [](const Mesh& m, ElementKind kind) {
    for (const MeshProblem& problem : validate_mesh(m).problems)
      if (problem.kind == ProblemKind::DuplicateElement && problem.element == kind) return problem.count;
    return std::size_t{0};
  };
  Mesh other = mesh;
  const auto hex = mesh.hex_to_vert[1];
  other.hex_to_vert.push_back({hex[3], hex[0], hex[1], hex[2], hex[7], hex[4], hex[5], hex[6]});
  const auto prism = mesh.prism_to_vert[3];
  other.prism_to_vert.push_back({prism[3], prism[4], prism[5], prism[0], prism[1], prism[2]});
  other.pyramid_to_vert.push_back(mesh.pyramid_to_vert[2]);
  other.hex_to_entity.push_back(0), other.prism_to_entity.push_back(0), other.pyramid_to_entity.push_back(0);
  const auto quad = mesh.quad_to_vert[3];
  other.quad_to_vert.push_back({quad[2], quad[1], quad[0], quad[3]});
  other.quad_to_entity.push_back(mesh.quad_to_entity[3]);
  for (const ElementKind kind : {ElementKind::Hex, ElementKind::Prism, ElementKind::Pyramid, ElementKind::Quad}) {
    INFO(to_string(kind));
    CHECK(count(mesh, kind) == 0);
    CHECK(count(other, kind) == 1);
  }
}

TEST_CASE("a face of four points against two triangles is found, surface elements or not") {
  // A cube on a cube, the upper one of six tets.
  Mesh mesh;
  const Mesh tets = test::make_tet_box(1, 1, 2);
  mesh.points = tets.points;
  for (std::size_t t = 6; t < 12; ++t) mesh.tet_to_vert.push_back(tets.tet_to_vert[t]);
  mesh.hex_to_vert = {{0, 1, 3, 2, 4, 5, 7, 6}};
  mesh.tet_to_entity.assign(6, 0), mesh.hex_to_entity = {0};
  CHECK(messages(validate_mesh(mesh)) == "faces of hexes with four points against triangles: 1; ");
}

TEST_CASE("quadrilaterals over the same points in another cycle do not fit together") {
  Mesh mesh = test::make_mixed_box(3, 3, 4);
  std::swap(mesh.quad_to_vert[0][0], mesh.quad_to_vert[0][1]);
  const std::string found = messages(validate_mesh(mesh));
  CHECK(found.find("quads that are not a face of any cell: 1;") != std::string::npos);
  CHECK(found.find("without a triangle or quad: 1;") != std::string::npos);
}

TEST_CASE("fields of the wrong length are named and end nothing else") {
  Mesh mesh = test::make_mixed_box(3, 3, 4);
  mesh.point_fields = {{"heat", 1, std::vector<double>(mesh.points.size())}};
  mesh.cell_fields = {{"flow", 3, std::vector<double>(3 * cell_count(mesh))}};
  CHECK(messages(validate_mesh(mesh)) == "");
  mesh.cell_fields[0].values.pop_back();
  mesh.point_fields[0].components = 0;
  const ValidationReport report = validate_mesh(mesh);
  REQUIRE(report.problems.size() == 2);
  CHECK(report.problems[0].kind == ProblemKind::ArrayLength);
  CHECK(report.boundary_faces > 0);
}
