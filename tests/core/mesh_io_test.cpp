#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstring>
#include <limits>
#include <random>

#include "tests/core/mesh_fixtures.hpp"
#include "tests/core/mesh_io_support.hpp"
#include "tetloom/check.hpp"
#include "tetloom/io.hpp"

using namespace tetloom;
using test::check_same_elements;
using test::error_of;
using test::TemporaryFolder;
using test::written_and_read;

namespace {

/// Two regions, awkward coordinates, full classification.
Mesh sample() {
  Mesh mesh = test::make_box(4, 3, 3, true, 1.0 / 3);
  test::jitter(mesh, 0.05, 42);
  test::decorate(mesh);
  return mesh;
}

/// The same mesh in an order of elements that no format would choose.
Mesh shuffled_elements(Mesh mesh) {
  std::mt19937 random(11);
  const auto shuffle = [&](auto& elements, auto& entities) {
    for (std::size_t i = elements.size(); i-- > 1;) {
      const std::size_t j = random() % (i + 1);
      std::swap(elements[i], elements[j]);
      std::swap(entities[i], entities[j]);
    }
  };
  shuffle(mesh.edge_to_vert, mesh.edge_to_entity);
  shuffle(mesh.tri_to_vert, mesh.tri_to_entity);
  shuffle(mesh.tet_to_vert, mesh.tet_to_entity);
  return mesh;
}

constexpr std::array<const char*, 4> kExact{".vtu", ".msh", ".mesh", ".meshb"};

}  // namespace

TEST_CASE("points, elements and classification come back bit for bit") {
  for (const char* extension : kExact) {
    INFO(extension);
    const Mesh mesh = sample();
    const Mesh read = written_and_read(mesh, extension);
    check_same_elements(read, mesh);
    CHECK(mesh_digest(read) == mesh_digest(mesh));
    CHECK(validate_mesh(read).valid());
    const Mesh shuffled = shuffled_elements(mesh);
    check_same_elements(written_and_read(shuffled, extension), shuffled);
  }
}

TEST_CASE("extreme coordinates come back bit for bit") {
  Mesh mesh = sample();
  mesh.points[0] = {5e-324, -0.0, 1e308};
  mesh.points[1] = {0.1, 1.0 / 3, -1e-300};
  mesh.points[2] = {123456789.123456789, 1e22, std::nextafter(1.0, 2.0)};
  mesh.points[3] = {std::numeric_limits<double>::infinity(), -std::numeric_limits<double>::infinity(), 0};
  for (const char* extension : kExact) {
    INFO(extension);
    CHECK(test::same_points(written_and_read(mesh, extension), mesh));
  }
}

TEST_CASE("names, colours, layers, tolerances and sides come back from VTU") {
  const Mesh mesh = sample();
  const Mesh read = written_and_read(mesh, ".vtu");
  CHECK(test::same_attributes(read, mesh));
  CHECK(test::same_sides(read, mesh));
}

TEST_CASE("names and sides come back from MSH, in a form that the format holds") {
  Mesh mesh = sample();
  mesh.entities[2][1].name = "two\nlines and \"quotes\"";
  mesh.entities[2][3].name = std::string(254, 'x') + "ü";  // 256 bytes
  const Mesh read = written_and_read(mesh, ".msh");
  CHECK(test::same_sides(read, mesh));
  REQUIRE(read.entities[2].size() == mesh.entities[2].size());
  REQUIRE(read.entities[3].size() == 2);
  CHECK(read.entities[3][0].name == mesh.entities[3][0].name);
  CHECK(read.entities[2][2].name == mesh.entities[2][2].name);
  CHECK(read.entities[2][1].name == "two lines and 'quotes'");
  CHECK(read.entities[2][3].name == std::string(254, 'x'));
}

TEST_CASE("surface meshes keep their sides, and meshes of one kind of element come back") {
  for (const char* extension : kExact) {
    INFO(extension);
    Mesh mesh = sample();
    mesh.tet_to_vert.clear();
    mesh.tet_to_entity.clear();
    for (ModelEntity& entity : mesh.point_to_entity)
      if (entity.dim == 3) entity = {};
    Mesh read = written_and_read(mesh, extension);
    check_same_elements(read, mesh);
    if (!std::string(extension).starts_with(".mesh")) CHECK(test::same_sides(read, mesh));
    mesh = sample();
    mesh.tri_to_vert.clear(), mesh.edge_to_vert.clear();
    mesh.tri_to_entity.clear(), mesh.edge_to_entity.clear();
    for (ModelEntity& entity : mesh.point_to_entity) entity = {};
    mesh.tet_to_entity.assign(mesh.tet_to_vert.size(), ModelRegionId::kNone);
    check_same_elements(written_and_read(mesh, extension), mesh);
    mesh.point_to_entity.clear();
    CHECK(written_and_read(mesh, extension).point_to_entity.size() == mesh.points.size());
  }
}

TEST_CASE("an STL file holds the triangles, with one point for each that was there") {
  Mesh mesh = test::make_box(3, 4, 5);
  const Mesh read = written_and_read(mesh, ".stl");
  REQUIRE(read.tri_to_vert.size() == mesh.tri_to_vert.size());
  for (std::size_t t = 0; t < read.tri_to_vert.size(); ++t)
    for (int i = 0; i < 3; ++i) CHECK(read.points[read.tri_to_vert[t][i]] == mesh.points[mesh.tri_to_vert[t][i]]);
  CHECK(read.points.size() == 2u * (3 * 4 + 4 * 5 + 3 * 5) + 2);
  CHECK(validate_mesh(read).open_edges == 0);
}

TEST_CASE("a text STL is read") {
  const TemporaryFolder folder;
  const std::string facet =
      "facet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex +1.0e0 -0 0\nvertex 0 1 0\nendloop\nendfacet\n";
  test::write_file(folder / "a.stl",
                   "solid my part\n" + facet + facet + "endsolid my part\nsolid b\n" + facet + "endsolid\n");
  const Mesh mesh = read_mesh(folder / "a.stl");
  CHECK(mesh.points.size() == 3);
  CHECK(mesh.tri_to_vert.size() == 3);
}

TEST_CASE("extensions are known in any case, others are refused with the list of known ones") {
  CHECK(is_mesh_extension("a/b.VTU"));
  CHECK(is_writable_mesh_format("a.MeshB"));
  CHECK_FALSE(is_mesh_extension("a.step"));
  CHECK_FALSE(is_writable_mesh_format("vtu"));
  CHECK_FALSE(is_writable_mesh_format(""));
  const TemporaryFolder folder;
  const Mesh mesh = test::make_box(1, 1, 1);
  write_mesh(mesh, folder / "UPPER.VTU");
  check_same_elements(read_mesh(folder / "UPPER.VTU"), mesh);
  for (const char* name : {"a.step", "a", "a.vtk"}) {
    for (const Diagnostic& error : {error_of([&] { write_mesh(mesh, folder / name); }),
                                    error_of([&] { static_cast<void>(read_mesh(folder / name)); })}) {
      CHECK(error.code == ErrorCode::InvalidArgument);
      CHECK_THAT(error.message, Catch::Contains(".mesh, .meshb, .msh, .stl"));
    }
  }
}

TEST_CASE("meshes that make no file are refused before one is begun") {
  const TemporaryFolder folder;
  const auto refuse = [&](const Mesh& mesh, const std::string& name) {
    CHECK(error_of([&] { write_mesh(mesh, folder / name); }).code == ErrorCode::InvalidArgument);
    CHECK(folder.file_count() == 0);
  };
  Mesh mesh = test::make_box(1, 1, 1);
  mesh.tri_to_vert.clear();
  mesh.tri_to_entity.clear();
  refuse(mesh, "no-triangles.stl");
  mesh.tet_to_vert[0][0] = 99;
  for (const char* extension : kExact) refuse(mesh, test::joined("broken", extension));
  mesh = test::make_box(1, 1, 1);
  mesh.tet_to_entity[0] = 0x80000000u;
  refuse(mesh, "tag.msh");
  // MEDIT has a version with wide integers for that.
  CHECK(written_and_read(mesh, ".meshb").tet_to_entity == mesh.tet_to_entity);
  CHECK(written_and_read(mesh, ".vtu").tet_to_entity == mesh.tet_to_entity);
}
