// MED and CGNS files: what is written comes back; damaged ones are refused.
#include <random>

#include "tests/core/mesh_fixtures.hpp"
#include "tests/core/mesh_io_support.hpp"
#include "tetloom/check.hpp"
#include "tetloom/io.hpp"

using namespace tetloom;
using test::survive;
using test::TemporaryFolder;

namespace {

Mesh one_of_each() {
  Mesh mesh;
  mesh.points = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {0, 0, 1}, {1, 0, 1}, {1, 1, 1}, {0, 1, 1}};
  mesh.hex_to_vert = {{0, 1, 2, 3, 4, 5, 6, 7}};
  mesh.hex_to_entity = {4};
  mesh.prism_to_vert = {{0, 1, 2, 4, 5, 6}};
  mesh.prism_to_entity = {3};
  mesh.pyramid_to_vert = {{0, 1, 2, 3, 4}};
  mesh.pyramid_to_entity = {2};
  mesh.tet_to_vert = {{0, 1, 2, 4}};
  mesh.tet_to_entity = {kNone};
  mesh.quad_to_vert = {{0, 3, 2, 1}};
  mesh.quad_to_entity = {6};
  mesh.edge_to_vert = {{0, 1}};
  mesh.edge_to_entity = {0};
  mesh.point_to_entity.assign(8, {});
  mesh.point_to_entity[0] = {0, 5};
  return mesh;
}

}  // namespace

TEST_CASE("MED files give elements and classification back") {
  const TemporaryFolder folder;
  const Mesh box = test::make_box(4, 2, 2, true);
  write_mesh(box, folder / "box.med");
  test::check_same_elements(read_mesh(folder / "box.med"), box);
  Mesh named = box;
  named.entities[2].resize(3);
  named.entities[2][1].name = "inlet";
  write_mesh(named, folder / "named.med");
  const Mesh back = read_mesh(folder / "named.med");
  REQUIRE(back.entities[2].size() == 2);
  CHECK(back.entities[2][1].name == "inlet");
  write_mesh(one_of_each(), folder / "each.med");
  const Mesh each = read_mesh(folder / "each.med");
  CHECK(each.hex_to_vert == one_of_each().hex_to_vert);
  CHECK(each.prism_to_vert == one_of_each().prism_to_vert);
  CHECK(each.pyramid_to_vert == one_of_each().pyramid_to_vert);
  CHECK(each.pyramid_to_entity == one_of_each().pyramid_to_entity);
  CHECK(each.tet_to_entity == one_of_each().tet_to_entity);
  CHECK(each.quad_to_vert == one_of_each().quad_to_vert);
  CHECK(each.point_to_entity[0] == ModelEntity(0, 5));
}

TEST_CASE("CGNS files give elements and their entities back") {
  const TemporaryFolder folder;
  write_mesh(one_of_each(), folder / "each.cgns");
  const Mesh each = read_mesh(folder / "each.cgns");
  CHECK(each.hex_to_vert == one_of_each().hex_to_vert);
  CHECK(each.prism_to_vert == one_of_each().prism_to_vert);
  CHECK(each.prism_to_entity == one_of_each().prism_to_entity);
  CHECK(each.tet_to_entity == one_of_each().tet_to_entity);
  CHECK(each.quad_to_entity == one_of_each().quad_to_entity);
  CHECK(each.edge_to_entity == one_of_each().edge_to_entity);
}

TEST_CASE("damaged MED and CGNS files never do harm") {
  const TemporaryFolder folder;
  for (const char* extension : {".med", ".cgns"}) {
    const auto good = folder / test::joined("good", extension), bad = folder / test::joined("bad", extension);
    write_mesh(test::make_box(2, 1, 1, true), good);
    const std::string content = test::file_content(good);
    std::mt19937 random(3);
    INFO("seed 3");
    for (int round = 0; round < 300; ++round) {
      std::string damaged = content;
      if (round % 3 == 0) damaged.resize(random() % content.size() + 1);
      for (int change = 0; change < 3; ++change) damaged[random() % damaged.size()] = static_cast<char>(random());
      test::write_file(bad, damaged);
      survive(bad);
    }
  }
}
