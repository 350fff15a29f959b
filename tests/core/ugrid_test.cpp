// UGRID files and the .mapbc files beside them: our own, those that others write, and damaged ones.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cstring>
#include <random>

#include "core/mesh/mesh_access.hpp"
#include "tests/core/mesh_fixtures.hpp"
#include "tests/core/mesh_io_support.hpp"
#include "tests/support/mixed_mesh.hpp"
#include "tetloom/check.hpp"
#include "tetloom/io.hpp"

using namespace tetloom;
using test::content_of;
using test::error_for;
using test::error_of;
using test::file_content;
using test::read_content;
using test::TemporaryFolder;
using test::write_file;
using test::written_and_read;

namespace {

constexpr std::array<const char*, 3> kNames{"a.lb8.ugrid", "a.b8.ugrid", "a.ugrid"};

/// What UGRID files hold of a mesh: neither edges nor regions.
Mesh held_of(Mesh mesh) {
  mesh.edge_to_vert.clear();
  mesh.edge_to_entity.clear();
  for_each_cell_kind(mesh, [](CellKind, const auto&, auto& regions) { std::ranges::fill(regions, kNone); });
  mesh.face_to_sides.clear();
  mesh.entities = {};
  return mesh;
}

/// A file as text: a box of one hexahedron, a pyramid on its top and a prism at its side, in UGRID's numbering, with
/// some of its boundary, which points into the domain.
const std::string kForeign = R"(12  2 1  0 1 1 1
0 0 0   1 0 0   1 1 0   0 1 0
0 0 1   1 0 1   1 1 1   0 1 1
0.5 0.5 2
2 0 0   2 0 1   2 0 3
6 5 9
10 3 2
1 2 3 4
7 7 40
6 5 9 7 8
2 10 3 6 11 7
1 2 3 4
5 6 7 8
)";

}  // namespace

TEST_CASE("UGRID files come back as far as they hold a mesh") {
  for (const Mesh& mesh : {test::make_tet_box(3, 2, 2), test::make_tet_box(4, 2, 2, 0, true),
                           test::make_mixed_box(4, 3, 5, 7, false), test::make_mixed_box(4, 3, 5, 7, true)})
    for (const char* name : kNames) {
      INFO(name);
      const Mesh read = written_and_read(mesh, name);
      Mesh held = held_of(mesh);
      held.point_to_entity = read.point_to_entity;
      test::check_same_elements(read, held);
      CHECK(mesh_digest(read) == mesh_digest(held));
      CHECK(validate_mesh(read).valid());
    }
}

TEST_CASE("points of UGRID files are classified on the faces that have them") {
  const Mesh mesh = test::make_tet_box(3, 3, 3), read = written_and_read(mesh, "a.lb8.ugrid");
  for (std::size_t v = 0; v < mesh.points.size(); ++v)
    if (mesh.point_to_entity[v].dim == 2) CHECK(read.point_to_entity[v] == mesh.point_to_entity[v]);
}

TEST_CASE("UGRID files of surfaces come back") {
  Mesh mesh = held_of(test::make_tet_box(2, 2, 2));
  mesh.tet_to_vert.clear();
  mesh.tet_to_entity.clear();
  for (const char* name : kNames) CHECK(written_and_read(mesh, name).tri_to_vert == mesh.tri_to_vert);
}

TEST_CASE("boundary triangles of UGRID files point into the domain") {
  const std::string text = content_of(test::make_tet_box(1, 1, 1), "a.ugrid");
  Mesh read = read_content("a.ugrid", text);
  std::vector<double> volumes;
  // Seen from a tet with the triangle, its fourth vertex lies behind.
  for (const auto& [a, b, c] : read.tri_to_vert)
    for (const auto& tet : read.tet_to_vert) {
      const auto has = [&](std::uint32_t v) { return std::ranges::find(tet, v) != tet.end(); };
      if (!has(a) || !has(b) || !has(c)) continue;
      const std::uint32_t d = tet[0] ^ tet[1] ^ tet[2] ^ tet[3] ^ a ^ b ^ c;
      const auto& x = read.points;
      volumes.push_back(dot(cross(x[b] - x[a], x[c] - x[a]), x[d] - x[a]));
    }
  REQUIRE(volumes.size() == read.tri_to_vert.size());
  CHECK(std::ranges::all_of(volumes, [](double volume) { return volume < 0; }));
  const auto& [a, b, c] = read.tri_to_vert[0];
  const std::string line = std::to_string(a + 1) + " " + std::to_string(c + 1) + " " + std::to_string(b + 1) + "\n";
  CHECK(text.find("\n" + line) != std::string::npos);
}

TEST_CASE("a face whose region lies in front is turned over") {
  Mesh mesh = test::make_tet_box(2, 2, 2);
  for (auto& verts : mesh.tri_to_vert) std::swap(verts[1], verts[2]);
  for (FaceSides& sides : mesh.face_to_sides) std::swap(sides.front, sides.back);
  CHECK(content_of(mesh, "a.ugrid") == content_of(test::make_tet_box(2, 2, 2), "a.ugrid"));
}

TEST_CASE("a UGRID file of another program is read with its order of vertices") {
  const Mesh mesh = read_content("A.UGRID", kForeign);
  CHECK(mesh.pyramid_to_vert == std::vector<std::array<std::uint32_t, 5>>{{4, 5, 6, 7, 8}});
  CHECK(mesh.prism_to_vert == std::vector<std::array<std::uint32_t, 6>>{{1, 9, 2, 5, 10, 6}});
  CHECK(mesh.hex_to_vert.size() == 1);
  CHECK(mesh.tri_to_vert == std::vector<std::array<std::uint32_t, 3>>{{5, 8, 4}, {9, 1, 2}});
  CHECK(mesh.tri_to_entity == std::vector<std::uint32_t>{6, 6});
  CHECK(mesh.quad_to_vert == std::vector<std::array<std::uint32_t, 4>>{{0, 3, 2, 1}});
  CHECK(mesh.quad_to_entity == std::vector<std::uint32_t>{39});
  CHECK(mesh.point_to_entity[8] == ModelEntity(2, 6));
  CHECK_FALSE(mesh.point_to_entity[11].valid());
}

TEST_CASE("a stream of UGRID has its bytes in their places") {
  const std::string swapped = content_of(read_content("a.ugrid", kForeign), "a.b8.ugrid");
  CHECK(swapped.size() == 4 * 7 + 12 * 24 + 4 * (2 * 3 + 4 + 3 + 5 + 6 + 8));
  CHECK(swapped.substr(0, 8) == std::string("\0\0\0\x0c\0\0\0\x02", 8));
  CHECK(swapped.substr(28 + 24, 8) == std::string("\x3f\xf0\0\0\0\0\0\0", 8));       // the x of the second point
  CHECK(swapped.substr(28 + 12 * 24, 8) == std::string("\0\0\0\x06\0\0\0\x05", 8));  // the first triangle
  const std::string plain = content_of(read_content("a.ugrid", kForeign), "a.lb8.ugrid");
  CHECK(plain.substr(0, 8) == std::string("\x0c\0\0\0\x02\0\0\0", 8));
}

TEST_CASE("what stands behind the cells is passed over") {
  const Mesh mesh = read_content("a.ugrid", kForeign + "1\n0 1 2 3 4 5\n");
  CHECK(cell_count(mesh) == 3);
}

TEST_CASE("names of faces stand in a .mapbc file") {
  Mesh mesh = test::make_tet_box(2, 2, 2);
  mesh.entities[2].resize(6);
  mesh.entities[2][0].name = "inlet";
  mesh.entities[2][2].group = mesh.entities[2][4].group = "walls";
  for (const char* name : kNames) {
    INFO(name);
    const TemporaryFolder folder;
    write_mesh(mesh, folder / name);
    CHECK(file_content(folder / "a.mapbc") ==
          "6\n1 0 inlet\n2 0 face_2\n3 0 walls\n4 0 face_4\n5 0 walls\n6 0 face_6\n");
    const Mesh read = read_mesh(folder / name);
    REQUIRE(read.entities[2].size() == 5);
    CHECK(read.entities[2][0].name == "inlet");
    CHECK(read.entities[2][1].name.empty());
    CHECK(read.entities[2][2].group == "walls");
    CHECK(read.entities[2][4].group == "walls");
    write_mesh(read, folder / "b.ugrid");
    CHECK(file_content(folder / "b.mapbc") == file_content(folder / "a.mapbc"));
  }
}

TEST_CASE("codes of boundary conditions outlive the mesh") {
  const TemporaryFolder folder;
  const Mesh mesh = test::make_tet_box(1, 1, 1);
  write_file(folder / "a.mapbc", "3 of them\n 2  4000   wing\n9 1 gone\n 5 -1\n");
  write_mesh(mesh, folder / "a.b8.ugrid");
  CHECK(file_content(folder / "a.mapbc") ==
        "6\n1 0 face_1\n2 4000 face_2\n3 0 face_3\n4 0 face_4\n5 -1 face_5\n6 0 face_6\n");
}

TEST_CASE("a .mapbc file that is none is refused, and not replaced") {
  const TemporaryFolder folder;
  const Mesh mesh = test::make_tet_box(1, 1, 1);
  write_mesh(mesh, folder / "a.ugrid");
  const std::string good = file_content(folder / "a.ugrid");
  for (const auto& [text, reason] : std::vector<std::pair<std::string, std::string>>{
           {"2\n1 4000 wing\nfour\n", "line 3"}, {"2\n1 4000 wing\n", "line 3"}, {"99999999999 x\n", "exceeds"}}) {
    write_file(folder / "a.mapbc", text);
    const Diagnostic error = error_of([&] { static_cast<void>(read_mesh(folder / "a.ugrid")); });
    CHECK(error.code == ErrorCode::InputUnreadable);
    CHECK_THAT(error.message, Catch::Contains(reason) && Catch::Contains("a.mapbc"));
    CHECK(error_of([&] { write_mesh(test::make_tet_box(2, 1, 1), folder / "a.ugrid"); }).code ==
          ErrorCode::InputUnreadable);
    CHECK(file_content(folder / "a.ugrid") == good);
    CHECK(file_content(folder / "a.mapbc") == text);
    CHECK(folder.file_count() == 2);
  }
}

TEST_CASE("tags beyond all measure name no faces") {
  const TemporaryFolder folder;
  write_file(folder / "a.ugrid", "3 1 0 0 0 0 0\n0 0 0 1 0 0 0 1 0\n1 2 3\n2147483647\n");
  write_file(folder / "a.mapbc", "1\n2147483647 3000 far\n");
  const Mesh mesh = read_mesh(folder / "a.ugrid");
  CHECK(mesh.tri_to_entity == std::vector<std::uint32_t>{2147483646});
  CHECK(mesh.entities[2].empty());
}

TEST_CASE("UGRID files are known by the two parts of their extension") {
  for (const char* name : {"a.lb8.ugrid", "A.B8.UGRID", "a.b.c.ugrid"}) {
    CHECK(is_mesh_extension(name));
    CHECK(is_writable_mesh_format(name));
  }
  CHECK_FALSE(is_mesh_extension("a.lb8"));
  CHECK_FALSE(is_mesh_extension(".ugrid"));
  CHECK_THAT(error_for("a.lb4.ugrid", content_of(test::make_tet_box(1, 1, 1), "a.lb8.ugrid")).message,
             Catch::Contains(".b8.ugrid"));
}

TEST_CASE("UGRID files cut off anywhere are refused") {
  const Mesh mesh = test::make_mixed_box(1, 1, 4);
  for (const char* name : kNames) {
    INFO(name);
    const std::string content = content_of(mesh, name);
    const TemporaryFolder folder;
    // Of a text, the line end may be missing, and digits of the last number.
    const std::size_t end = name == std::string("a.ugrid") ? content.rfind(' ') + 2 : content.size();
    for (std::size_t size = 1; size < end; ++size) {
      write_file(folder / name, content.substr(0, size));
      const Diagnostic error = error_of([&] { static_cast<void>(read_mesh(folder / name)); });
      if (error.code != ErrorCode::InputUnreadable) FAIL_CHECK(size << ": " << error.message);
    }
  }
}

TEST_CASE("damaged UGRID files never do harm") {
  constexpr unsigned kSeed = 11;
  std::mt19937 random(kSeed);
  INFO("seed " << kSeed);
  const Mesh mesh = test::make_mixed_box(1, 1, 4);
  for (const char* name : kNames) {
    const std::string content = content_of(mesh, name);
    const TemporaryFolder folder;
    for (std::size_t at = 0; at < content.size(); ++at) {
      std::string damaged = content;
      damaged[at] = static_cast<char>(damaged[at] ^ (1 + random() % 255));
      write_file(folder / name, damaged);
      try {
        static_cast<void>(mesh_digest(read_mesh(folder / name)));
      } catch (const Error& error) {
        if (error.code() != ErrorCode::InputUnreadable && error.code() != ErrorCode::InputUnsuitable)
          FAIL_CHECK("unexpected error: " << error.what());
      }
    }
  }
}

TEST_CASE("counts that a UGRID file does not back are refused before memory is allocated for them") {
  for (std::size_t place = 0; place < 7; ++place) {
    std::string text, stream;
    for (std::size_t i = 0; i < 7; ++i) {
      text += i == place ? "2000000000 " : "0 ";
      stream += i == place ? std::string("\xff\xff\xff\x7f", 4) : std::string(4, '\0');
    }
    for (const Diagnostic& error : {error_for("a.ugrid", text), error_for("a.lb8.ugrid", stream)}) {
      CHECK(error.code == ErrorCode::InputUnreadable);
      CHECK_THAT(error.message, Catch::Contains("exceeds the file"));
    }
  }
  CHECK_THAT(error_for("a.ugrid", "-3 1 0 0 0 0 0\n").message, Catch::Contains("negative"));
  CHECK_THAT(error_for("a.ugrid", "3 0 0 0 0 0 0\n0 0 0 1 0 0 0 1 0\n").message, Catch::Contains("no "));
  for (const char* index : {"0", "4", "-1", "4294967297", "9223372036854775807"})
    CHECK_THAT(error_for("a.ugrid", "3 1 0 0 0 0 0\n0 0 0 1 0 0 0 1 0\n1 2 " + std::string(index) + "\n1\n").message,
               Catch::Contains("triangle 1"));
}
