#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <numeric>
#include <random>
#include <set>
#include <string>
#include <tuple>
#include <vector>

#include "core/mesh/mesh_access.hpp"
#include "tests/support/mixed_mesh.hpp"
#include "tetloom/check.hpp"
#include "tetloom/error.hpp"

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

template <class Array>
void reorder(Array& array, const std::vector<std::size_t>& order, std::size_t first = 0, std::size_t width = 1) {
  const Array old = array;
  for (std::size_t i = 0; i < order.size(); ++i)
    for (std::size_t c = 0; c < width; ++c) array[(first + i) * width + c] = old[(first + order[i]) * width + c];
}

std::vector<std::size_t> random_order(std::size_t size, std::mt19937& random) {
  std::vector<std::size_t> order(size);
  std::iota(order.begin(), order.end(), 0u);
  std::shuffle(order.begin(), order.end(), random);
  return order;
}

/// The same cell in another of its numberings.
template <class Cell>
void turn(Cell& v) {
  const Cell o = v;
  if constexpr (std::tuple_size_v<Cell> == 4) v = {o[1], o[0], o[3], o[2]};
  if constexpr (std::tuple_size_v<Cell> == 5) v = {o[2], o[3], o[0], o[1], o[4]};
  if constexpr (std::tuple_size_v<Cell> == 6) v = {o[5], o[4], o[3], o[2], o[1], o[0]};
  if constexpr (std::tuple_size_v<Cell> == 8) v = {o[5], o[1], o[0], o[4], o[6], o[2], o[3], o[7]};
}

/// The same mesh and fields with points and cells renumbered, and cells and quadrilaterals turned.
Mesh shuffled(Mesh mesh, unsigned seed) {
  std::mt19937 random(seed);
  const std::vector<std::size_t> order = random_order(mesh.points.size(), random);
  std::vector<std::uint32_t> place(order.size());
  for (std::uint32_t i = 0; i < order.size(); ++i) place[order[i]] = i;
  reorder(mesh.points, order);
  reorder(mesh.point_to_entity, order);
  for (MeshField& f : mesh.point_fields) reorder(f.values, order, 0, static_cast<std::size_t>(f.components));
  const auto renumber = [&](auto& elements) {
    for (auto& element : elements)
      for (auto& v : element) v = place[v];
  };
  renumber(mesh.edge_to_vert);
  for_each_surface_kind(mesh, [&](auto& elements, auto&) { renumber(elements); });
  for (auto& quad : mesh.quad_to_vert) std::rotate(quad.begin(), quad.begin() + random() % 4, quad.end());
  std::size_t first = 0;
  for_each_cell_kind(mesh, [&](CellKind, auto& cells, auto& regions) {
    renumber(cells);
    for (auto& cell : cells) turn(cell);
    const std::vector<std::size_t> of_kind = random_order(cells.size(), random);
    reorder(cells, of_kind);
    reorder(regions, of_kind);
    for (MeshField& f : mesh.cell_fields) reorder(f.values, of_kind, first, static_cast<std::size_t>(f.components));
    first += cells.size();
  });
  return mesh;
}

Mesh with_fields() {
  Mesh mesh = test::make_mixed_box(4, 3, 5, 9, true);
  MeshField on_points{"p", 2, std::vector<double>(2 * mesh.points.size())};
  MeshField on_cells{"c", 3, std::vector<double>(3 * cell_count(mesh))};
  std::iota(on_points.values.begin(), on_points.values.end(), 0.5);
  std::iota(on_cells.values.begin(), on_cells.values.end(), -7.25);
  mesh.point_fields = {on_points};
  mesh.cell_fields = {on_cells, {"d", 1, std::vector<double>(cell_count(mesh), 4)}};
  return mesh;
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

TEST_CASE("digests of all kinds of cells and of fields do not depend on numbering") {
  const Mesh mesh = with_fields();
  for (unsigned seed = 1; seed <= 4; ++seed) {
    INFO("seed " << seed);
    const Mesh other = shuffled(mesh, seed);
    REQUIRE(messages(validate_mesh(other)) == "");
    CHECK(mesh_digest(other) == mesh_digest(mesh));
    CHECK(field_digest(other) == field_digest(mesh));
  }
  Mesh swapped = mesh;
  std::swap(swapped.cell_fields[0], swapped.cell_fields[1]);
  CHECK(field_digest(swapped) == field_digest(mesh));
}

TEST_CASE("every change of a cell or a quadrilateral changes the digest, fields do not") {
  const Mesh mesh = with_fields();
  std::set<std::string> digests{mesh_digest(mesh)};
  const auto changed = [&](const auto& change) {
    Mesh other = mesh;
    other.cell_fields.clear();
    change(other);
    return digests.insert(mesh_digest(other)).second;
  };
  CHECK_FALSE(changed([](Mesh& m) { m.point_fields.clear(); }));
  CHECK(changed([](Mesh& m) { std::swap(m.quad_to_vert[1][0], m.quad_to_vert[1][2]); }));
  CHECK(changed([](Mesh& m) { std::swap(m.quad_to_vert[1][0], m.quad_to_vert[1][1]); }));
  CHECK(changed([](Mesh& m) { m.quad_to_entity[1] += 1; }));
  CHECK(changed([](Mesh& m) { std::swap(m.hex_to_vert[1][0], m.hex_to_vert[1][1]); }));
  CHECK(changed([](Mesh& m) { m.hex_to_entity[1] ^= 1; }));
  CHECK(changed([](Mesh& m) { std::swap(m.prism_to_vert[1][0], m.prism_to_vert[1][1]); }));
  CHECK(changed([](Mesh& m) { m.prism_to_entity[1] ^= 1; }));
  CHECK(changed([](Mesh& m) { std::swap(m.pyramid_to_vert[1][0], m.pyramid_to_vert[1][1]); }));
  CHECK(changed([](Mesh& m) { m.pyramid_to_vert.pop_back(), m.pyramid_to_entity.pop_back(); }));
}

TEST_CASE("every change of a value, a name or what a value hangs on changes the digest of the fields") {
  const Mesh mesh = with_fields();
  std::set<std::string> digests{field_digest(mesh), field_digest(Mesh{})};
  const auto changed = [&](const auto& change) {
    Mesh other = mesh;
    change(other);
    return digests.insert(field_digest(other)).second;
  };
  CHECK(changed([](Mesh& m) { m.point_fields[0].values[9] += 1; }));
  CHECK(changed([](Mesh& m) { std::swap(m.point_fields[0].values[0], m.point_fields[0].values[2]); }));
  CHECK(changed([](Mesh& m) { std::swap(m.cell_fields[0].values[0], m.cell_fields[0].values[1]); }));
  CHECK(changed([](Mesh& m) { m.cell_fields[0].name = "cc"; }));
  CHECK(changed([](Mesh& m) { m.cell_fields.pop_back(); }));
  CHECK(changed([](Mesh& m) { m.points[3].x += 1; }));
  CHECK_FALSE(changed([](Mesh& m) { std::swap(m.cell_fields[1].values[0], m.cell_fields[1].values[1]); }));
  CHECK_THROWS_AS(changed([](Mesh& m) { m.cell_fields[0].values.pop_back(); }), Error);
}

TEST_CASE("the volume of a mesh is that of all its cells, region by region") {
  for (const unsigned seed : {0u, 5u}) {
    const QualityReport report = compute_quality(test::make_mixed_box(4, 3, 5, seed, true));
    CHECK(report.cells.volume == Approx(4 * 3 * 5));
    CHECK(report.tets.volume < report.cells.volume);
    CHECK(report.cells.inverted == 0);
    REQUIRE(report.cells.regions.size() == 2);
    for (const RegionQuality& region : report.cells.regions) {
      CHECK(region.volume == Approx(2 * 3 * 5));
      CHECK(region.cells > region.tets);
    }
  }
}

TEST_CASE("cells with a corner of no positive volume are counted") {
  Mesh mesh = test::make_mixed_box(3, 3, 4);
  std::swap(mesh.hex_to_vert[0][0], mesh.hex_to_vert[0][1]);
  std::swap(mesh.tet_to_vert[0][0], mesh.tet_to_vert[0][1]);
  const QualityReport report = compute_quality(mesh);
  CHECK(report.cells.inverted == 2);
  CHECK(report.tets.inverted == 1);
}

TEST_CASE("scaled Jacobians are 1 for the best cells, and not positive for inverted ones") {
  const double height = std::sqrt(3.0) / 2;
  Mesh mesh;
  mesh.points = {{0, 0, 0}, {1, 0, 0}, {0.5, height, 0}, {0, 0, 0.01}, {1, 0, 0.01}, {0.5, height, 0.01}};
  mesh.point_to_entity.assign(6, {});
  mesh.prism_to_vert = {{0, 1, 2, 3, 4, 5}};
  mesh.prism_to_entity = {0};
  CellQuality cells = compute_quality(mesh).cells;
  CHECK(cells.min_scaled_jacobian == Approx(1));
  CHECK(cells.scaled_jacobian_p1 == Approx(1));
  mesh.points[5].x += 0.01;  // as far as the prism is high
  CHECK(compute_quality(mesh).cells.min_scaled_jacobian == Approx(std::sqrt(0.5)).epsilon(0.02));
  mesh.points[5].z = -0.01;
  CHECK(compute_quality(mesh).cells.min_scaled_jacobian < 0);
  mesh.points[5] = mesh.points[2];
  CHECK(compute_quality(mesh).cells.min_scaled_jacobian == 0);
  CHECK(compute_quality(test::make_tet_box(1, 1, 1)).cells.min_scaled_jacobian == 1);
  CHECK(compute_quality(test::make_mixed_box(3, 3, 4)).cells.min_scaled_jacobian > 0.5);
}
