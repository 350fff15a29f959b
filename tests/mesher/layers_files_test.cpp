// Meshes with boundary layers in all files that hold their cells, and in other orders of cells.
#include <catch2/catch.hpp>
#include <filesystem>
#include <fstream>
#include <sstream>

#include "tests/support/analytic_model.hpp"
#include "tests/support/temporary_folder.hpp"
#include "tetloom/check.hpp"
#include "tetloom/io.hpp"
#include "tetloom/mesh.hpp"

using namespace tetloom;
using namespace tetloom::test_models;

namespace {

// Prisms, pyramids and tets in layers on four faces of a box, which stand on the two others.
Mesh layered_box(bool all_tets = false) {
  const auto box = make_box({0, 0, 0}, {2, 2, 1});
  MeshOptions options;
  options.sizes.size = 0.25;
  options.layers.all_tets = all_tets;
  for (std::uint32_t f = 0; f < 4; ++f) {
    WallLayers wall;
    wall.face = ModelFaceId(f);
    wall.first_height = 0.02, wall.count = f % 2 == 0 ? 14 : 8;
    options.layers.walls.push_back(wall);
  }
  MeshResult result = make_mesh(*box, options);
  REQUIRE(result.status == MeshStatus::Ok);
  return std::move(result.mesh);
}

std::string text_of(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  std::ostringstream text;
  text << file.rdbuf();
  return text.str();
}

std::size_t count(const std::string& text, const std::string& what) {
  std::size_t found = 0;
  for (std::size_t at = text.find(what); at != std::string::npos; at = text.find(what, at + 1)) ++found;
  return found;
}

}  // namespace

TEST_CASE("files that are read again give the cells of layers back, and their fields where they have some") {
  const Mesh mesh = layered_box();
  REQUIRE(mesh.prism_to_vert.size() > 100);
  REQUIRE(mesh.pyramid_to_vert.size() > 10);
  REQUIRE(mesh.quad_to_vert.size() > 10);
  const double volume = compute_quality(mesh).cells.volume;
  CHECK(volume == Approx(4).epsilon(1e-12));
  const test::TemporaryFolder folder;
  for (const char* name :
       {"a.vtu", "a.msh", "a.mesh", "a.meshb", "a.inp", "a.med", "a.cgns", "a.su2", "a.ugrid", "a.lb8.ugrid"}) {
    CAPTURE(name);
    write_mesh(mesh, folder / name);
    const Mesh read = read_mesh(folder / name);
    CHECK(read.prism_to_vert.size() == mesh.prism_to_vert.size());
    CHECK(read.pyramid_to_vert.size() == mesh.pyramid_to_vert.size());
    CHECK(read.tet_to_vert.size() == mesh.tet_to_vert.size());
    CHECK(read.quad_to_vert.size() == mesh.quad_to_vert.size());
    CHECK(validate_mesh(read).valid());
    const QualityReport quality = compute_quality(read);
    CHECK(quality.cells.inverted == 0);
    CHECK(quality.cells.volume == Approx(volume).epsilon(1e-12));
    CHECK(quality.cells.min_scaled_jacobian == Approx(compute_quality(mesh).cells.min_scaled_jacobian));
  }
  for (const char* name : {"a.vtu", "a.msh"}) {
    CAPTURE(name);
    const Mesh read = read_mesh(folder / name);
    CHECK(mesh_digest(read) == mesh_digest(mesh));
    CHECK(field_digest(read) == field_digest(mesh));
  }
}

TEST_CASE("files that are only written have all cells of layers") {
  const Mesh mesh = layered_box();
  const std::size_t cells = mesh.prism_to_vert.size() + mesh.pyramid_to_vert.size() + mesh.tet_to_vert.size();
  const test::TemporaryFolder folder;
  write_mesh(mesh, folder / "a.bdf");
  const std::string nastran = text_of(folder / "a.bdf");
  CHECK(count(nastran, "\nCPENTA") == mesh.prism_to_vert.size());
  CHECK(count(nastran, "\nCPYRAM") == mesh.pyramid_to_vert.size());
  CHECK(count(nastran, "\nCTETRA") == mesh.tet_to_vert.size());
  write_mesh(mesh, folder / "a.foam");
  CHECK(text_of(folder / "a.foam/constant/polyMesh/owner").find("nCells:" + std::to_string(cells)) !=
        std::string::npos);
  write_mesh(mesh, folder / "a.vtkhdf");
  const std::string hdf = text_of(folder / "a.vtkhdf");
  for (const char* field : {"layer", "height", "stack"}) CHECK(hdf.find(field) != std::string::npos);
  write_mesh(mesh, folder / "a.msh", {.msh_2_2 = true});
  CHECK(read_mesh(folder / "a.msh").prism_to_vert.size() == mesh.prism_to_vert.size());
}

TEST_CASE("layers that are split into tets are a valid mesh with the same fields") {
  const Mesh mesh = layered_box(true);
  CHECK(mesh.prism_to_vert.empty());
  CHECK(validate_mesh(mesh).valid());
  CHECK(compute_quality(mesh).tets.inverted == 0);
  CHECK(mesh.cell_fields.size() == 3);
  const test::TemporaryFolder folder;
  write_mesh(mesh, folder / "a.vtu");
  CHECK(field_digest(read_mesh(folder / "a.vtu")) == field_digest(mesh));
}
