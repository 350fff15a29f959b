#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstdio>
#include <limits>
#include <random>

#include "core/mesh/mesh_access.hpp"
#include "tests/core/mesh_io_support.hpp"
#include "tests/support/mixed_mesh.hpp"
#include "tetloom/check.hpp"
#include "tetloom/io.hpp"

using namespace tetloom;
using test::check_same_elements;
using test::error_for;
using test::error_of;
using test::read_content;
using test::TemporaryFolder;
using test::written_and_read;

namespace {

MeshField random_field(std::string name, int components, std::size_t carriers, std::mt19937_64& random) {
  MeshField field{std::move(name), components, {}};
  for (std::size_t i = 0; i < carriers * static_cast<std::size_t>(components); ++i)
    field.values.push_back(std::ldexp(static_cast<double>(random()), static_cast<int>(random() % 200) - 150));
  field.values[2] = std::numeric_limits<double>::infinity();
  field.values[3] = -0.0;
  return field;
}

/// All kinds of cells in two regions, with fields whose names files like to trip over.
Mesh mixed_sample() {
  Mesh mesh = test::make_mixed_box(4, 3, 5, 7, true);
  std::mt19937_64 random(3);
  mesh.point_fields = {random_field("temperature", 1, mesh.points.size(), random),
                       random_field("u <&> 'ü'", 3, mesh.points.size(), random),
                       random_field("five", 5, mesh.points.size(), random)};
  mesh.cell_fields = {random_field("stress", 9, cell_count(mesh), random),
                      random_field("temperature", 1, cell_count(mesh), random)};
  return mesh;
}

/// A triangle and a prism of positive volume on it.
const std::string kMshStart = R"($MeshFormat
4.1 0 8
$EndMeshFormat
$Nodes
1 6 1 6
3 1 0 6
1
2
3
4
5
6
0 0 0
1 0 0
0 1 0
0 0 1
1 0 1
0 1 1
$EndNodes
$Elements
2 2 7 9
2 1 2 1
9 1 2 3
3 1 6 1
7 1 2 3 4 5 6
$EndElements
)";

std::string view(const std::string& section, const std::string& step, const std::string& values) {
  return "$" + section + "\n1\n\"heat\"\n1\n0.5\n3\n" + step + "\n" + values + "$End" + section + "\n";
}

std::string wedge_vtu(const std::string& cell_data) {
  return "<VTKFile type='UnstructuredGrid'><UnstructuredGrid><Piece NumberOfPoints='6' NumberOfCells='1'><Points>"
         "<DataArray type='Float64' NumberOfComponents='3'>0 0 0 0 1 0 1 0 0 0 0 1 0 1 1 1 0 1</DataArray></Points>"
         "<Cells><DataArray type='Int32' Name='connectivity'>0 1 2 3 4 5</DataArray>"
         "<DataArray type='Int32' Name='offsets'>6</DataArray><DataArray type='UInt8' Name='types'>13</DataArray>"
         "</Cells><CellData>" +
         cell_data + "</CellData></Piece></UnstructuredGrid></VTKFile>";
}

}  // namespace

TEST_CASE("all kinds of cells and their classification come back bit for bit") {
  for (const char* extension : {".vtu", ".msh", ".mesh", ".meshb"}) {
    INFO(extension);
    const Mesh mesh = mixed_sample(), read = written_and_read(mesh, extension);
    check_same_elements(read, mesh);
    CHECK(mesh_digest(read) == mesh_digest(mesh));
    CHECK(validate_mesh(read).valid());
    const bool has_fields = std::string(extension).size() == 4;  // MEDIT holds none
    CHECK(test::same_fields(read.point_fields, has_fields ? mesh.point_fields : std::vector<MeshField>{}));
    CHECK(test::same_fields(read.cell_fields, has_fields ? mesh.cell_fields : std::vector<MeshField>{}));
    if (has_fields) CHECK(field_digest(read) == field_digest(mesh));
  }
}

TEST_CASE("prisms and wedges are turned as their formats want them") {
  const Mesh wedge = read_content(".vtu", wedge_vtu(""));
  CHECK(wedge.prism_to_vert[0] == std::array<std::uint32_t, 6>{0, 2, 1, 3, 5, 4});
  CHECK(compute_quality(wedge).cells.volume == Approx(0.5));
  const Mesh prism = read_content(".msh", kMshStart);
  CHECK(compute_quality(prism).cells.volume == Approx(0.5));
}

TEST_CASE("meshio reads the same cells, volumes and fields") {
  if (!test::has_meshio()) return;
  const TemporaryFolder folder;
  const Mesh mesh = mixed_sample();
  write_mesh(mesh, folder / "mesh.vtu");
  const std::string script = R"(
import sys, meshio, numpy as np
m = meshio.read(sys.argv[1])
p = m.points
wanted = {'tetra': (0, 1, 2, 3), 'pyramid': (0, 1, 3, 4), 'wedge': (0, 1, 2, 3), 'hexahedron': (0, 1, 3, 4)}
for b in m.cells:
    if b.type in wanted:
        a = [p[b.data[:, i]] for i in wanted[b.type]]
        assert (np.einsum('ij,ij->i', np.cross(a[1] - a[0], a[2] - a[0]), a[3] - a[0]) > 0).all(), b.type
        assert len(b.data) == int(sys.argv[2 + list(wanted).index(b.type)]), b.type
if len(sys.argv) > 6:
    assert m.point_data["u <&> 'ü'"].shape == (len(p), 3)
    assert m.point_data['temperature'][0] == float(sys.argv[6])
)";
  test::write_file(folder / "read.py", script);
  char value[40];
  std::snprintf(value, sizeof value, "%.17g", mesh.point_fields[0].values[0]);
  for (const std::string extension : {".vtu", ".mesh"}) {
    INFO(extension);
    write_mesh(mesh, folder / test::joined("mesh", extension));
    std::string command = "/usr/bin/python3 '" + (folder / "read.py").string() + "' '" +
                          (folder / test::joined("mesh", extension)).string() + "'";
    for (const CellKind kind : kAllCellKinds) command += " " + std::to_string(cell_count(mesh, kind));
    if (extension == ".vtu") command += std::string(" ") + value;
    const bool fine = test::succeeds(command, folder / "log");
    INFO(test::file_content(folder / "log"));
    CHECK(fine);
  }
}

TEST_CASE("arrays of any type of number are fields, those of the classification are not") {
  const Mesh mesh = read_content(
      ".vtu", wedge_vtu("<DataArray type='Int8' Name='a&lt;b' NumberOfComponents='2'>-3 4</DataArray>"
                        "<DataArray type='Float32' Name='f'>0.5</DataArray><DataArray type='Int32' Name='material'>"
                        "8</DataArray><DataArray type='UInt32' Name='MaterialIDs'>9</DataArray>"
                        "<DataArray type='String' Name='s'>65 0</DataArray>"));
  REQUIRE(mesh.cell_fields.size() == 3);
  CHECK(mesh.cell_fields[0].name == "a<b");
  CHECK(mesh.cell_fields[0].values == std::vector<double>{-3, 4});
  CHECK(mesh.cell_fields[1].values == std::vector<double>{0.5});
  CHECK(mesh.cell_fields[2].name == "MaterialIDs");
  CHECK(mesh.prism_to_entity[0] == 7);
}

TEST_CASE("fields of the wrong length are refused in files") {
  for (const char* array : {"<DataArray type='Int8' Name='a'>1 2</DataArray>",
                            "<DataArray type='Int8' Name='a' NumberOfComponents='0'>1</DataArray>",
                            "<DataArray type='Int8' Name='a' NumberOfComponents='x'>1</DataArray>"}) {
    INFO(array);
    CHECK(error_for(".vtu", wedge_vtu(array)).code == ErrorCode::InputUnreadable);
  }
  for (const std::string values : {"0\n1\n2\n7 1.5\n", "0\n0\n1\n7 1.5\n", "0\n1\n-1\n7 1\n", "0\n3\n1\n7 1\n"}) {
    INFO(values);
    CHECK(error_for(".msh", kMshStart + view("ElementData", values, "")).code == ErrorCode::InputUnreadable);
  }
  CHECK(error_for(".msh", kMshStart + view("NodeData", "0\n1\n1", "17 1\n")).code == ErrorCode::InputUnreadable);
  CHECK(error_for(".msh", kMshStart + view("NodeData", "0\n1000000\n1", "1 1\n")).code == ErrorCode::InputUnreadable);
}

TEST_CASE("of a view the first time step counts, parts of it are put together, and gaps are NaN") {
  const Mesh mesh =
      read_content(".msh", kMshStart + view("NodeData", "4\n1\n2", "1 10\n3 30\n") +
                               view("NodeData", "4\n1\n1", "6 60\n") + view("NodeData", "5\n1\n1", "1 99\n") +
                               view("ElementData", "0\n1\n2", "9 1\n7 2\n") + view("ElementData", "1\n1\n1", "9 1\n"));
  REQUIRE(mesh.point_fields.size() == 1);
  const std::vector<double>& heat = mesh.point_fields[0].values;
  REQUIRE(heat.size() == 6);
  CHECK((heat[0] == 10 && heat[2] == 30 && heat[5] == 60 && std::isnan(heat[1])));
  REQUIRE(mesh.cell_fields.size() == 1);
  CHECK(mesh.cell_fields[0].values == std::vector<double>{2});
}

TEST_CASE("fields that make no file are refused before one is begun") {
  const TemporaryFolder folder;
  const auto refuse = [&](const Mesh& mesh) {
    CHECK(error_of([&] { write_mesh(mesh, folder / "a.vtu"); }).code == ErrorCode::InvalidArgument);
    CHECK(folder.file_count() == 0);
  };
  const auto with = [](MeshField field) {
    Mesh mesh = test::make_mixed_box(1, 1, 4);
    if (field.values.empty()) field.values.resize(cell_count(mesh));
    mesh.cell_fields = {std::move(field)};
    return mesh;
  };
  refuse(with({"short", 1, {1}}));
  refuse(with({"none", 0, {}}));
  refuse(with({"", 1, {}}));
  refuse(with({"two\nlines", 1, {}}));
  refuse(with({"region", 1, {}}));
  Mesh twice = with({"twice", 1, {}});
  twice.cell_fields.push_back(twice.cell_fields[0]);
  refuse(twice);
}

TEST_CASE("damaged files of mixed meshes with fields are refused with a reason, or hold some mesh") {
  const TemporaryFolder folder;
  Mesh mesh = test::make_mixed_box(1, 1, 4);
  mesh.point_fields = {{"p", 2, std::vector<double>(2 * mesh.points.size(), 0.5)}};
  mesh.cell_fields = {{"c", 1, std::vector<double>(cell_count(mesh), 1)}};
  std::mt19937 random(5);
  for (const char* extension : {".vtu", ".msh", ".mesh", ".meshb"}) {
    const auto path = folder / test::joined("a", extension);
    write_mesh(mesh, path);
    const std::string good = test::file_content(path);
    for (int i = 0; i < 400; ++i) {
      INFO(extension << " " << i);
      std::string bad = good;
      if (i % 2 == 0)
        bad.resize(1 + random() % (bad.size() - 1));
      else
        for (int k = 0; k < 3; ++k) bad[random() % bad.size()] = static_cast<char>(random());
      test::write_file(path, bad);
      try {
        const Mesh read = read_mesh(path);
        CHECK(field_digest(read).size() == 32);
      } catch (const Error& error) {
        const bool expected = error.code() == ErrorCode::InputUnreadable || error.code() == ErrorCode::InputUnsuitable;
        CHECK((expected && !error.diagnostic().message.empty()));
      }
    }
  }
}
