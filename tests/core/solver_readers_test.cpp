// Files of solvers, read back: those of our own, those that others write, and damaged ones.
#include <catch2/catch.hpp>
#include <cstring>
#include <random>

#include "core/mesh/mesh_access.hpp"
#include "tests/core/mesh_fixtures.hpp"
#include "tests/core/mesh_io_support.hpp"
#include "tests/support/mixed_mesh.hpp"
#include "tests/support/second_order_mesh.hpp"
#include "tetloom/check.hpp"
#include "tetloom/io.hpp"

using namespace tetloom;
using test::error_of;
using test::file_content;
using test::read_content;
using test::TemporaryFolder;
using test::with_mid_nodes;
using test::write_file;
using test::written_and_read;

namespace {

/// A box of two regions without names: files call its entities by their tags.
Mesh unnamed_box() { return test::make_box(4, 3, 2, true); }

std::string reason(const std::string& name, const std::string& text) {
  return error_of([&] { static_cast<void>(read_content(name, text)); }).message;
}

/// What Abaqus files hold: cells, and elements on faces, which may come in another order.
Mesh without_edges(Mesh mesh) {
  mesh.edge_to_vert.clear();
  mesh.edge_to_entity.clear();
  mesh.point_to_entity.clear();
  return mesh;
}

std::string digest_of_elements(Mesh mesh) { return mesh_digest(without_edges(std::move(mesh))); }

const std::string kTetNodes = "*Node\n 10, 0., 0., 0.\n 20, 1., 0, 0\n30,0,1e0,0\n40 ,0, 0, 1.\n";

}  // namespace

TEST_CASE("Abaqus files come back with regions and faces by their tags") {
  for (const Mesh& mesh : {unnamed_box(), test::make_mixed_box(4, 3, 5, 7, true)}) {
    const Mesh read = written_and_read(mesh, "a.inp");
    CHECK(read.tet_to_vert == mesh.tet_to_vert);
    CHECK(read.tet_to_entity == mesh.tet_to_entity);
    CHECK(read.hex_to_vert == mesh.hex_to_vert);
    CHECK(read.tri_to_vert.size() == mesh.tri_to_vert.size());
    CHECK(validate_mesh(read).valid());
  }
}

TEST_CASE("Abaqus files of one region come back to the digest") {
  for (const Mesh& mesh : {test::make_box(3, 3, 2), test::make_mixed_box(4, 3, 5, 7, false)})
    CHECK(digest_of_elements(written_and_read(mesh, "a.inp")) == digest_of_elements(mesh));
}

TEST_CASE("Abaqus files of second order come back") {
  const Mesh mesh = with_mid_nodes(test::make_tet_box(3, 2, 2), [](const Vec3& x) { return Vec3{0, 0.01 * x.x, 0}; });
  const Mesh read = written_and_read(mesh, "a.inp");
  CHECK(read.mid_to_vert == mesh.mid_to_vert);
  CHECK(digest_of_elements(read) == digest_of_elements(mesh));
}

TEST_CASE("names in Abaqus files become those of entities") {
  const Mesh mesh =
      read_content("a.inp", "** made by hand\n*HEADING\n anything, here\n" + kTetNodes +
                                "*element , type = c3d4 , elset=The Body\n7,10,20,\n30,40\n"
                                "*Material, name=steel\n*Elastic\n210000., 0.3\n"
                                "*ELSET, ELSET=all, GENERATE\n1, 9, 2\n"
                                "*SURFACE, NAME=Base\nThe Body, S1\n*Surface, name=face_9, type=element\n7,S3\n");
  REQUIRE(mesh.tet_to_vert.size() == 1);
  REQUIRE(mesh.entities[3].size() == 1);
  CHECK(mesh.entities[3][0].name == "The Body");
  REQUIRE(mesh.tri_to_entity.size() == 2);
  CHECK(mesh.entities[2].at(0).name == "Base");
  CHECK(mesh.tri_to_entity[1] == 8);
  CHECK(mesh.tet_to_entity[0] == 0);
}

TEST_CASE("Abaqus files that make no sense are refused with the line") {
  const std::string element = "*ELEMENT, TYPE=C3D4\n1,10,20,30,40\n";
  CHECK_THAT(reason("a.inp", kTetNodes + "*ELEMENT, TYPE=C3D4\n1,10,20,30,x\n"), Catch::Contains("line 7"));
  CHECK_THAT(reason("a.inp", kTetNodes + "*ELEMENT, TYPE=C3D4\n1,10,20,30\n*STEP\n"), Catch::Contains("too few"));
  CHECK_THAT(reason("a.inp", kTetNodes + "*ELEMENT, TYPE=C3D4\n1,10,20,30,40,50\n"), Catch::Contains("too many"));
  CHECK_THAT(reason("a.inp", kTetNodes + "*ELEMENT, TYPE=C3D4\n1,10,20,30,50\n"), Catch::Contains("tet 1"));
  CHECK_THAT(reason("a.inp", kTetNodes + "*ELEMENT, TYPE=C3D27\n"), Catch::Contains("C3D27"));
  CHECK_THAT(reason("a.inp", kTetNodes + element + "1,10,20,30,40\n"), Catch::Contains("same number"));
  CHECK_THAT(reason("a.inp", kTetNodes + "10,0,0,0\n" + element), Catch::Contains("same tag"));
  CHECK_THAT(reason("a.inp", "*INCLUDE, INPUT=other.inp\n"), Catch::Contains("*INCLUDE"));
  CHECK_THAT(reason("a.inp", "*PART, NAME=a\n*END PART\n*PART, NAME=b\n"), Catch::Contains("several parts"));
  CHECK_THAT(reason("a.inp", kTetNodes + element + "*ELSET, ELSET=a, GENERATE\n5,1\n"), Catch::Contains("range"));
  CHECK_THAT(reason("a.inp", "no keyword at all\n"), Catch::Contains("no points"));
}

TEST_CASE("SU2 files come back with faces by their tags") {
  Mesh mesh = unnamed_box();
  const Mesh read = written_and_read(mesh, "a.su2");
  CHECK(read.tet_to_vert == mesh.tet_to_vert);
  CHECK(test::same_points(read, mesh));
  // Faces between regions are no markers.
  std::size_t boundary = 0;
  for (const std::uint32_t face : mesh.tri_to_entity)
    boundary += mesh.face_to_sides[face].front.valid() != mesh.face_to_sides[face].back.valid();
  CHECK(read.tri_to_vert.size() == boundary);
  CHECK(validate_mesh(read).valid());
}

TEST_CASE("SU2 files of others are read, in two dimensions as surfaces") {
  const Mesh mesh =
      read_content("a.su2",
                   "% by hand\nNDIME=2\nNELEM= 2 % triangles\n5 0 1 2 0\n5 0 2 3 1\nNPOIN= 4 4\n0 0 0\n1 0 1\n"
                   "1 1 2\n0 1e0 3\nNMARK= 2\nMARKER_TAG= lower\nMARKER_ELEMS= 1\n3 0 1\nMARKER_TAG= edge_5\n"
                   "MARKER_ELEMS= 1\n3 1 2 0\n");
  CHECK(mesh.tri_to_vert.size() == 2);
  CHECK(mesh.edge_to_entity == std::vector<std::uint32_t>{0, 4});
  CHECK(mesh.entities[1].at(0).name == "lower");
  CHECK(mesh.points[2] == Vec3{1, 1, 0});

  CHECK_THAT(reason("a.su2", "NDIME= 4\n"), Catch::Contains("line 1"));
  CHECK_THAT(reason("a.su2", "NDIME= 3\nNELEM= 1\n10 0 1 2\n"), Catch::Contains("line"));
  CHECK_THAT(reason("a.su2", "NDIME= 3\nNELEM= 1\n42 0 1 2 3\n"), Catch::Contains("42"));
  CHECK_THAT(reason("a.su2", "NDIME= 3\nNELEM= 1\n10 0 1 2 9\nNPOIN= 4\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n"),
             Catch::Contains("tet 1"));
  CHECK_THAT(reason("a.su2", "NDIME= 3\nNELEM= 99999999999\n10 0 1 2 3\n"), Catch::Contains("exceeds"));
  CHECK_THAT(reason("a.su2", "NZONE= 2\n"), Catch::Contains("several zones"));
  CHECK_THAT(reason("a.su2", "NDIME= 3\nMARKER_ELEMS= 1\n5 0 1 2\n"), Catch::Contains("MARKER_TAG"));
}

TEST_CASE("MSH 2.2 comes back from binary files as from text") {
  for (const Mesh& mesh : {unnamed_box(), test::make_mixed_box(4, 3, 5, 7, true),
                           with_mid_nodes(test::make_mixed_box(2, 2, 4, 3, false))}) {
    const Mesh text = written_and_read(mesh, "a.msh", {.msh_2_2 = true, .text = true});
    const Mesh binary = written_and_read(mesh, "a.msh", {.msh_2_2 = true});
    CHECK(mesh_digest(binary) == mesh_digest(text));
    CHECK(binary.tet_to_vert == mesh.tet_to_vert);
    CHECK(binary.tet_to_entity == mesh.tet_to_entity);
    CHECK(binary.mid_to_vert == mesh.mid_to_vert);
  }
}

TEST_CASE("solvers' files cut off or changed anywhere are refused, or hold some mesh") {
  const TemporaryFolder folder;
  const Mesh mesh = with_mid_nodes(test::make_tet_box(2, 1, 1, 0, true)),
             straight = test::make_tet_box(2, 1, 1, 0, true);
  std::mt19937 random(5);
  for (const char* name : {"a.inp", "a.su2", "a.msh"}) {
    INFO(name);
    write_mesh(std::string(name) == "a.su2" ? straight : mesh, folder / name, {.msh_2_2 = true});
    const std::string content = file_content(folder / name);
    const auto survive = [&](const std::string& text) {
      write_file(folder / name, text);
      try {
        static_cast<void>(mesh_digest(read_mesh(folder / name)));
      } catch (const Error& error) {
        const bool expected = error.code() == ErrorCode::InputUnreadable || error.code() == ErrorCode::InputUnsuitable;
        if (!expected || error.diagnostic().message.empty()) FAIL_CHECK("unexpected error: " << error.what());
      }
    };
    for (std::size_t size = 1; size < content.size(); size += 13) survive(content.substr(0, size));
    for (int i = 0; i < 500; ++i) {
      std::string text = content;
      text[random() % text.size()] = static_cast<char>(random());
      survive(text);
    }
  }
}
