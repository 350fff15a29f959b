// polyMeshes of OpenFOAM, read back by a few lines here.
#include <catch2/catch.hpp>
#include <sstream>

#include "core/mesh/mesh_access.hpp"
#include "tests/core/mesh_fixtures.hpp"
#include "tests/core/mesh_io_support.hpp"
#include "tests/core/solver_text.hpp"
#include "tests/support/mixed_mesh.hpp"
#include "tetloom/io.hpp"

using namespace tetloom;
using test::error_of;
using test::file_content;
using test::named_box;
using test::numbers_in;
using test::signed_volume;
using test::TemporaryFolder;

namespace {

/// The items of a list of OpenFOAM, one a line.
std::vector<std::vector<double>> foam_list(const std::filesystem::path& path) {
  std::istringstream stream(file_content(path));
  std::string line;
  while (std::getline(stream, line) && line != "(") {}
  std::vector<std::vector<double>> items;
  while (std::getline(stream, line) && line != ")") items.push_back(numbers_in(line));
  return items;
}

}  // namespace

TEST_CASE("polyMesh: cells are closed, their volumes those of the mesh, and faces in upper-triangular order") {
  for (const bool mixed : {false, true}) {
    const Mesh mesh = mixed ? test::make_mixed_box(4, 3, 5, 7, true) : named_box();
    const TemporaryFolder folder;
    write_mesh(mesh, folder / "case.foam");
    std::filesystem::create_directories(folder / "case.foam/constant/polyMesh/sets");
    write_mesh(mesh, folder / "case.foam");  // its own files are replaced, and what checkMesh left
    const std::filesystem::path poly = folder / "case.foam" / "constant" / "polyMesh";
    CHECK(std::filesystem::exists(folder / "case.foam" / "system" / "controlDict"));
    const auto points = foam_list(poly / "points"), faces = foam_list(poly / "faces"),
               owner = foam_list(poly / "owner"), neighbour = foam_list(poly / "neighbour");
    REQUIRE(points.size() == mesh.points.size());
    REQUIRE(owner.size() == faces.size());
    std::vector<double> volumes(cell_count(mesh), 0);
    std::vector<Vec3> areas(cell_count(mesh));
    std::pair<double, double> last{-1, -1};
    for (std::size_t f = 0; f < faces.size(); ++f) {
      REQUIRE(static_cast<double>(faces[f].size()) == faces[f][0] + 1);
      std::vector<Vec3> polygon;
      for (std::size_t k = 1; k < faces[f].size(); ++k) {
        const auto& x = points[static_cast<std::size_t>(faces[f][k])];
        polygon.push_back({x[0], x[1], x[2]});
      }
      Vec3 area;
      for (std::size_t i = 2; i < polygon.size(); ++i)
        area = area + 0.5 * cross(polygon[i - 1] - polygon[0], polygon[i] - polygon[0]);
      const auto own = static_cast<std::size_t>(owner[f][0]);
      volumes[own] += signed_volume(polygon, {});
      areas[own] = areas[own] + area;
      if (f >= neighbour.size()) continue;
      const auto other = static_cast<std::size_t>(neighbour[f][0]);
      CHECK(own < other);
      CHECK(last < std::pair(owner[f][0], neighbour[f][0]));
      last = {owner[f][0], neighbour[f][0]};
      volumes[other] -= signed_volume(polygon, {});
      areas[other] = areas[other] - area;
    }
    double total = 0;
    for (std::size_t c = 0; c < volumes.size(); ++c) {
      CHECK(volumes[c] > 0);
      CHECK(norm(areas[c]) < 1e-12);
      total += volumes[c];
    }
    CHECK(total == Approx(mixed ? 60 : 24));
    if (mixed) continue;
    const std::string boundary = file_content(poly / "boundary"), zones = file_content(poly / "cellZones");
    CHECK(boundary.find("no_face") == std::string::npos);
    CHECK(zones.find("Geh_use_links\n") != std::string::npos);
    CHECK(zones.find("steel\n") != std::string::npos);
    CHECK(file_content(poly / "faceZones").find("}\n\n1\n(\n") != std::string::npos);
  }
}

TEST_CASE("polyMesh: points that no cell has are left out, and the others are the same") {
  const TemporaryFolder folder;
  Mesh mesh = named_box();
  write_mesh(mesh, folder / "a.foam");
  mesh.points.insert(mesh.points.begin(), {Vec3{9, 9, 9}, Vec3{8, 8, 8}});
  mesh.point_to_entity.insert(mesh.point_to_entity.begin(), 2, mesh.point_to_entity.front());
  for_each_cell_kind(mesh, [](CellKind, auto& cells, const auto&) {
    for (auto& cell : cells)
      for (std::uint32_t& v : cell) v += 2;
  });
  for (auto& edge : mesh.edge_to_vert)
    for (std::uint32_t& v : edge) v += 2;
  for (auto& triangle : mesh.tri_to_vert)
    for (std::uint32_t& v : triangle) v += 2;
  write_mesh(mesh, folder / "b.foam");
  for (const char* file : {"points", "faces", "owner", "neighbour", "boundary"})
    CHECK(file_content(folder / "a.foam" / "constant/polyMesh" / file) ==
          file_content(folder / "b.foam" / "constant/polyMesh" / file));
}

TEST_CASE("polyMesh: what is not ours stays, and boundary faces without triangles have a patch") {
  const TemporaryFolder folder;
  Mesh mesh = named_box();
  mesh.tri_to_vert.clear(), mesh.tri_to_entity.clear();
  write_mesh(mesh, folder / "a" / "polyMesh");
  CHECK(file_content(folder / "a" / "polyMesh" / "boundary").find("no_face") != std::string::npos);
  test::write_file(folder / "a" / "polyMesh" / "notes.txt", "mine");
  CHECK(error_of([&] { write_mesh(mesh, folder / "a" / "polyMesh"); }).code == ErrorCode::OutputFailed);
  CHECK(file_content(folder / "a" / "polyMesh" / "notes.txt") == "mine");
  mesh.tet_to_vert.clear(), mesh.tet_to_entity.clear();
  CHECK(error_of([&] { write_mesh(mesh, folder / "b.foam"); }).code == ErrorCode::InvalidArgument);
  CHECK_FALSE(std::filesystem::exists(folder / "b.foam"));
}
