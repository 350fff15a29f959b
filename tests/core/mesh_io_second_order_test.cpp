// Meshes of second order in files.
#include <catch2/catch.hpp>
#include <cmath>
#include <numeric>
#include <random>
#include <sstream>

#include "core/mesh/mesh_access.hpp"
#include "tests/core/mesh_io_support.hpp"
#include "tests/support/mixed_mesh.hpp"
#include "tests/support/second_order_mesh.hpp"
#include "tetloom/check.hpp"
#include "tetloom/io.hpp"

using namespace tetloom;
using test::check_same_elements;
using test::error_for;
using test::error_of;
using test::file_content;
using test::TemporaryFolder;
using test::with_mid_nodes;
using test::written_and_read;

namespace {

Vec3 bulge(const Vec3& x) { return {0.02 * std::sin(3 * x.y), 0.01 * std::cos(2 * x.z), 0.02 * std::sin(x.x)}; }

Mesh second_order_sample() {
  Mesh mesh = with_mid_nodes(test::make_mixed_box(4, 3, 5, 7, true), bulge);
  mesh.point_fields = {{"temperature", 1, {}}};
  for (const Vec3& x : mesh.points) mesh.point_fields[0].values.push_back(x.x + 2 * x.y);
  return mesh;
}

/// A tet of Gmsh, whose last two mid nodes are those of the edges 2 3 and 1 3, with numbers that do not put vertices
/// first, and a point that only `more` may use.
std::string gmsh_tet(const std::string& nodes = "9 2 7 4 1 3 5 6 8 10", const std::string& more = "") {
  return "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n11\n1 .5 0 0\n2 1 0 0\n3 .5 .5 0\n4 0 0 1\n5 0 .5 0\n"
         "6 0 0 .5\n7 0 1 0\n8 0 .5 .5\n9 0 0 0\n10 .5 0 .5\n11 1 1 1\n$EndNodes\n$Elements\n" +
         std::to_string(more.empty() ? 1 : 2) + "\n1 11 2 3 3 " + nodes + "\n" + more + "$EndElements\n";
}

}  // namespace

TEST_CASE("meshes of second order come back as they were") {
  const Mesh mesh = second_order_sample();
  for (const char* extension : {".vtu", ".msh"}) {
    INFO(extension);
    const Mesh read = written_and_read(mesh, extension);
    check_same_elements(mesh, read);
    CHECK(read.mid_to_vert == mesh.mid_to_vert);
    CHECK(test::same_fields(read.point_fields, mesh.point_fields));
    CHECK(mesh_digest(read) == mesh_digest(mesh));
  }
}

TEST_CASE("all kinds of cells of second order come back from formats that renumber points or drop their entities") {
  const Mesh mesh = with_mid_nodes(test::make_mixed_box(3, 3, 4, 3), bulge);
  const QualityReport before = compute_quality(mesh);
  REQUIRE(before.curved.count > 100);
  for (const char* extension : {".med", ".cgns"}) {
    INFO(extension);
    const Mesh read = written_and_read(mesh, extension);
    REQUIRE(read.mid_to_vert.size() == mesh.mid_to_vert.size());
    for (const CellKind kind : kAllCellKinds) CHECK(cell_count(read, kind) == cell_count(mesh, kind));
    const QualityReport after = compute_quality(read);
    CHECK(after.curved.count == before.curved.count);
    CHECK(after.curved.not_positive == before.curved.not_positive);
    CHECK(after.curved.min_scaled_jacobian == Approx(before.curved.min_scaled_jacobian).margin(2e-3));
    CHECK(after.curved.volume == Approx(before.curved.volume).epsilon(1e-12));
  }
}

TEST_CASE("MSH 2.2 of second order comes back, but for the points that model vertices lie on") {
  const Mesh mesh = with_mid_nodes(test::make_tet_box(3, 2, 2), bulge);
  const Mesh read = written_and_read(mesh, ".msh", {.msh_2_2 = true, .text = true});
  CHECK(read.mid_to_vert == mesh.mid_to_vert);
  CHECK(test::same_points(read, mesh));
  CHECK(read.tet_to_vert == mesh.tet_to_vert);
  for (std::size_t m = vertex_count(mesh); m < mesh.points.size(); ++m)
    CHECK(read.point_to_entity[m] == mesh.point_to_entity[m]);
}

TEST_CASE("mid nodes among the vertices are put behind them, with what hangs on them") {
  const TemporaryFolder folder;
  test::write_file(folder / "a.msh", gmsh_tet());
  const Mesh mesh = read_mesh(folder / "a.msh");
  REQUIRE(mesh.points.size() == 11);
  REQUIRE(mesh.mid_to_vert.size() == 6);
  const QualityReport quality = compute_quality(mesh);
  CHECK(quality.curved.count == 0);  // every mid node is in the middle of its own edge
  CHECK(quality.tets.volume == Approx(1.0 / 6));
  for (std::size_t p = 0; p < mesh.points.size(); ++p)  // the unused point is the last vertex
    CHECK(mesh.point_to_entity[p] == (p == 4 ? ModelEntity() : ModelEntity(3, 2)));
}

TEST_CASE("files of second order that make no sense are refused with the reason") {
  const auto refuse = [](const std::string& text, const std::string& reason) {
    const Diagnostic error = error_for(".msh", text);
    CHECK_THAT(error.message, Catch::Contains(reason));
  };
  refuse(gmsh_tet("9 2 7 4 1 3 5 6 8 8"), "two edges");
  refuse(gmsh_tet("9 2 7 4 1 3 5 6 8 4"), "a vertex and a mid node");
  refuse(gmsh_tet("9 2 7 4 1 3 5 6 8 99"), "not there");
  refuse(gmsh_tet("9 2 7 4 1 3 5 6 8 10", "2 4 2 3 3 2 7 4 11\n"), "first and second order");
}

TEST_CASE("formats that hold no mesh of second order refuse it") {
  const TemporaryFolder folder;
  const Mesh mesh = with_mid_nodes(test::make_tet_box(1, 1, 1));
  for (const char* name : {"a.mesh", "a.meshb", "a.stl", "a.su2", "a.foam"}) {
    INFO(name);
    CHECK_FALSE(holds_second_order(folder / name));
    CHECK(error_of([&] { write_mesh(mesh, folder / name); }).code == ErrorCode::InvalidArgument);
    CHECK_FALSE(std::filesystem::exists(folder / name));
  }
  for (const char* name : {"a.vtu", "a.msh", "a.inp", "a.bdf"}) CHECK(holds_second_order(folder / name));
}

TEST_CASE("Abaqus files have elements of second order, and node sets with mid nodes") {
  const TemporaryFolder folder;
  const Mesh mesh = with_mid_nodes(test::make_tet_box(1, 1, 1));
  write_mesh(mesh, folder / "a.inp");
  std::istringstream text(file_content(folder / "a.inp"));
  std::string line;
  std::size_t tets = 0, set_nodes = 0;
  bool in_tets = false, in_face = false;
  while (std::getline(text, line)) {
    if (line.starts_with('*')) {
      in_tets = line.starts_with("*ELEMENT, TYPE=C3D10");
      in_face = line == "*NSET, NSET=face_1";
      continue;
    }
    if (in_tets && ++tets == 1) CHECK(std::ranges::count(line, ',') == 10);
    if (in_face) set_nodes += static_cast<std::size_t>(std::ranges::count(line, ',')) + 1;
  }
  CHECK(tets == mesh.tet_to_vert.size());
  CHECK(set_nodes == 9);  // two triangles: four vertices and five edges
  const Mesh mixed = second_order_sample();
  CHECK_THAT(error_of([&] { write_mesh(mixed, folder / "b.inp"); }).message, Catch::Contains("pyramids"));
}

TEST_CASE("files of second order cut off or changed anywhere are refused, or hold some mesh") {
  const TemporaryFolder folder;
  const Mesh mesh = with_mid_nodes(test::make_tet_box(1, 1, 1), bulge);
  std::mt19937 random(11);
  for (const char* extension : {".vtu", ".msh"}) {
    const auto path = folder / test::joined("a", extension);
    write_mesh(mesh, path);
    const std::string content = file_content(path);
    const auto survive = [&](const std::string& text) {
      test::write_file(path, text);
      try {
        static_cast<void>(mesh_digest(read_mesh(path)));
      } catch (const Error& error) {
        CHECK_FALSE(error.diagnostic().message.empty());
      }
    };
    for (std::size_t size = 0; size < content.size(); size += 97) survive(content.substr(0, size));
    for (int i = 0; i < 300; ++i) {
      std::string text = content;
      text[random() % text.size()] = static_cast<char>(random());
      survive(text);
    }
  }
}
