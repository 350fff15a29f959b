// Files for solvers: the names of groups, which cell has which face, and each format read back by a few lines here.
#include <array>
#include <catch2/catch.hpp>
#include <map>
#include <set>
#include <sstream>

#include "core/io/solver/cell_faces.hpp"
#include "core/io/solver/groups.hpp"
#include "core/mesh/mesh_access.hpp"
#include "tests/core/mesh_fixtures.hpp"
#include "tests/core/mesh_io_support.hpp"
#include "tests/core/solver_text.hpp"
#include "tests/support/mixed_mesh.hpp"
#include "tetloom/io.hpp"

using namespace tetloom;
using namespace tetloom::detail;
using test::error_of;
using test::file_content;
using test::named_box;
using test::numbers_in;
using test::signed_volume;
using test::TemporaryFolder;

namespace {

/// The same with one face turned over: its region lies in front.
Mesh with_turned_face() {
  Mesh mesh = named_box();
  const std::uint32_t turned = mesh.tri_to_entity[0];
  std::swap(mesh.face_to_sides[turned].front, mesh.face_to_sides[turned].back);
  for (std::size_t t = 0; t < mesh.tri_to_vert.size(); ++t)
    if (mesh.tri_to_entity[t] == turned) std::swap(mesh.tri_to_vert[t][1], mesh.tri_to_vert[t][2]);
  return mesh;
}

std::string written(const Mesh& mesh, const std::string& extension, const WriteOptions& options = {}) {
  const TemporaryFolder folder;
  write_mesh(mesh, folder / test::joined("mesh", extension), options);
  return file_content(folder / test::joined("mesh", extension));
}

/// What stands behind each line that begins with a star, by that line.
std::map<std::string, std::vector<std::string>> sections_of(const std::string& text) {
  std::map<std::string, std::vector<std::string>> sections;
  std::istringstream stream(text);
  std::vector<std::string>* section = nullptr;
  for (std::string line; std::getline(stream, line);) {
    if (line.starts_with('*'))
      section = &sections[line];
    else if (section)
      section->push_back(line);
  }
  return sections;
}

}  // namespace

TEST_CASE("entities of one group are one set, patch, marker, property and physical group") {
  Mesh mesh = named_box();
  mesh.entities[2].resize(mesh.face_to_sides.size());
  mesh.entities[2][1].group = mesh.entities[2][3].group = "the load";
  mesh.entities[2][4].name = "the load";
  const Groups groups = make_groups(mesh);
  const auto found = std::ranges::find(groups[2], "the_load", &Group::name);
  REQUIRE(found != groups[2].end());
  CHECK(found->tags == std::vector<std::uint32_t>{2, 4});
  CHECK(std::ranges::is_sorted(found->elements));
  CHECK(std::ranges::count(groups[2], "the_load_2", &Group::name) == 1);
  std::size_t elements = 0;
  for (const Group& group : groups[2]) elements += group.elements.size();
  CHECK(elements == mesh.tri_to_vert.size());

  const auto sections = sections_of(written(mesh, ".inp"));
  CHECK(sections.at("*SURFACE, NAME=the_load, TYPE=ELEMENT").size() == found->elements.size());
  const std::string su2 = written(mesh, ".su2"), bdf = written(mesh, ".bdf");
  CHECK_THAT(su2,
             Catch::Contains("MARKER_TAG= the_load\nMARKER_ELEMS= " + std::to_string(found->elements.size()) + "\n"));
  CHECK_THAT(bdf, Catch::Contains("$ face the_load\n"));
  CHECK_THAT(written(mesh, ".msh", {.msh_2_2 = true, .text = true}), Catch::Contains("2 2 \"the_load\""));
  const auto names = solver_names(mesh);
  CHECK(std::ranges::count(names, "the_load", &NamedGroup::sanitised) == 2);
}

TEST_CASE("groups come back from VTU files, and name entities without a name in MSH files") {
  Mesh mesh = named_box();
  mesh.entities[2].assign(mesh.face_to_sides.size(), {});
  mesh.entities[2][1].group = mesh.entities[2][3].group = "load";
  mesh.entities[2][3].name = "top";
  const TemporaryFolder folder;
  write_mesh(mesh, folder / "a.vtu");
  CHECK(test::same_attributes(read_mesh(folder / "a.vtu"), mesh));
  write_mesh(mesh, folder / "a.msh");
  const Mesh read = read_mesh(folder / "a.msh");
  CHECK(read.entities[2].at(1).name == "load");
  CHECK(read.entities[2].at(3).name == "top");
}

TEST_CASE("MEDIT's boundary triangles point out of their region, in both forms") {
  const Mesh mesh = with_turned_face();
  const TemporaryFolder folder;
  for (const char* name : {"a.mesh", "a.meshb"}) {
    INFO(name);
    write_mesh(mesh, folder / name);
    const Mesh read = read_mesh(folder / name);
    REQUIRE(read.tri_to_vert.size() == mesh.tri_to_vert.size());
    for (std::size_t t = 0; t < mesh.tri_to_vert.size(); ++t)
      CHECK((read.tri_to_vert[t] == mesh.tri_to_vert[t]) != points_inwards(mesh, mesh.tri_to_entity[t]));
  }
}

TEST_CASE("numbers of Abaqus files are short enough for CalculiX, which reads 20 characters of them") {
  Mesh mesh = named_box();
  const std::vector<double> hard{6.1232339957367663e-16, -1.2345678901234567e-105, -0.035355339059327373,
                                 -1.7976931348623157e+308, 12345.678901234567};
  for (std::size_t i = 0; i < hard.size(); ++i) mesh.points[i].y = hard[i];
  const std::string text = written(mesh, ".inp");
  std::istringstream lines(text.substr(text.find("*NODE")));
  std::string line;
  std::getline(lines, line);
  for (std::size_t i = 0; i < mesh.points.size() && std::getline(lines, line); ++i) {
    std::istringstream fields(line);
    for (std::string field; std::getline(fields, field, ',');) CHECK(field.size() <= 20);
    CHECK(numbers_in(line).at(2) == Approx(mesh.points[i].y).epsilon(1e-12));
  }
}

TEST_CASE("names for solvers are words that begin with a letter") {
  CHECK(solver_name("inlet") == "inlet");
  CHECK(solver_name("inlet left/1") == "inlet_left_1");
  CHECK(solver_name("  Gehäuse 'links' ") == "Geh_use_links");
  CHECK(solver_name("2nd") == "n_2nd");
  CHECK(solver_name("äöü").empty());
  CHECK(solver_name("").empty());
  CHECK(solver_name(std::string(300, 'x')).size() == 64);
}

TEST_CASE("no two groups have one name, in any case of letters") {
  Mesh mesh = named_box();
  mesh.entities[2][0].name = "Wall";
  mesh.entities[2][1].name = "wall";
  mesh.entities[2][2].name = "wall_2";
  mesh.entities[2][3].name = std::string(300, 'a');
  mesh.entities[2][4].name = std::string(301, 'a');
  mesh.entities[3][0].name = "face_6";  // that of an unnamed face
  mesh.entities[2][5].name.clear();
  std::set<std::string> seen;
  for (const NamedGroup& group : solver_names(mesh)) {
    std::string lower = group.sanitised;
    for (char& c : lower) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    CHECK(seen.insert(lower).second);
    CHECK(group.sanitised.size() <= 64);
    if (group.entity == ModelEntity(ModelFaceId(1))) CHECK(group.original == "wall");
  }
  CHECK(seen.contains("wall"));
  CHECK(seen.contains("wall_2"));
  CHECK(seen.contains("edge_1"));
}

TEST_CASE("faces of cells are found by their vertices, and two cells share those between them") {
  const Mesh mesh = test::make_mixed_box(4, 3, 5, 7, true);
  const CellFaces faces(mesh, serial_loop());
  REQUIRE(faces.cell_count() == cell_count(mesh));
  std::map<std::set<std::uint32_t>, std::vector<std::uint32_t>> expected;
  for (std::uint32_t face = 0; face < faces.size(); ++face) {
    std::array<std::uint32_t, 4> buffer;
    const auto verts = faces.vertices(face, buffer);
    expected[std::set<std::uint32_t>(verts.begin(), verts.end())].push_back(face);
  }
  for (const auto& [verts, owners] : expected) {
    CHECK(faces.find(std::vector<std::uint32_t>(verts.begin(), verts.end())) == owners[0]);
    CHECK(faces.twin(owners[0]) == (owners.size() > 1 ? owners[1] : kNone));
    for (const std::uint32_t face : owners) CHECK(faces.first_face(faces.cell(face)) + faces.local(face) == face);
  }
  CHECK(faces.find(std::vector<std::uint32_t>{0, 1, static_cast<std::uint32_t>(mesh.points.size() - 1)}) == kNone);
}

TEST_CASE("where faces of the surface alone are looked up, they are found as among all") {
  const Mesh mesh = test::make_mixed_box(4, 3, 5, 7, true);
  const CellFaces all(mesh, serial_loop()), few(mesh, serial_loop(), FacesOf::Surface);
  CHECK(few.size() == all.size());
  std::size_t between = 0;
  for (std::uint32_t element = 0; element < surface_count(mesh); ++element) {
    const std::uint32_t face = all.find_surface(element);
    REQUIRE(face != kNone);
    CHECK(few.find_surface(element) == face);
    CHECK(few.find_side(element) == all.find_side(element));
    CHECK(few.twin(face) == all.twin(face));
    between += all.twin(face) != kNone ? 1 : 0;
  }
  CHECK(between > 0);
  // Faces without a vertex on the surface are known among all only.
  std::set<std::uint32_t> on_surface;
  for_each_surface_kind(mesh, [&](const auto& elements, const auto&) {
    for (const auto& element : elements) on_surface.insert(element.begin(), element.end());
  });
  std::size_t inside = 0;
  for (std::uint32_t face = 0; face < all.size(); ++face) {
    std::array<std::uint32_t, 4> buffer;
    const auto verts = all.vertices(face, buffer);
    if (std::ranges::any_of(verts, [&](std::uint32_t v) { return on_surface.contains(v); })) continue;
    ++inside;
    CHECK(all.find(verts) != kNone);
    CHECK(few.find(verts) == kNone);
    CHECK(few.twin(face) == kNone);
  }
  CHECK(inside > 0);
}

TEST_CASE("sides of a face between two regions are those of the region with the lower tag") {
  const Mesh mesh = test::make_mixed_box(4, 3, 5, 7, true);
  const CellFaces faces(mesh, serial_loop());
  std::size_t between = 0;
  const auto check_sides = [&](const std::vector<std::uint32_t>& entities, std::size_t before) {
    for (std::size_t i = 0; i < entities.size(); ++i) {
      const std::uint32_t side = faces.find_side(static_cast<std::uint32_t>(before + i));
      REQUIRE(side != kNone);
      if (faces.twin(side) == kNone) continue;
      ++between;
      Vec3 middle;
      std::array<std::uint32_t, 4> buffer;
      const std::uint32_t first = faces.first_face(faces.cell(side));
      for (const std::uint32_t v : faces.vertices(first, buffer)) middle += mesh.points[v];
      CHECK(middle.x / static_cast<double>(faces.vertices(first, buffer).size()) < 2 + 1e-12);  // region 1 lies there
    }
  };
  check_sides(mesh.tri_to_entity, 0);
  check_sides(mesh.quad_to_entity, mesh.tri_to_entity.size());
  CHECK(between > 0);
}

TEST_CASE(".inp has an element set per region, and per face its nodes and the element faces on it") {
  const Mesh mesh = named_box();
  const auto sections = sections_of(written(mesh, ".inp"));
  CHECK(sections.at("*NODE, NSET=all_nodes").size() == mesh.points.size());
  const auto& left = sections.at("*ELEMENT, TYPE=C3D4, ELSET=Geh_use_links");
  const auto& right = sections.at("*ELEMENT, TYPE=C3D4, ELSET=steel");
  CHECK(left.size() + right.size() == mesh.tet_to_vert.size());
  // Nodes of the faces 1 to 4, by their numbers in C3D4.
  constexpr std::array<std::array<int, 3>, 4> of_face{{{0, 1, 2}, {0, 3, 1}, {1, 3, 2}, {2, 3, 0}}};
  std::size_t sides = 0;
  const Groups groups = make_groups(mesh);
  for (const Group& group : groups[2]) {
    std::set<std::uint32_t> points;
    for (const std::string& line : sections.at("*SURFACE, NAME=" + group.name + ", TYPE=ELEMENT")) {
      const std::size_t comma = line.find(",S");
      REQUIRE(comma != std::string::npos);
      const auto& tet = mesh.tet_to_vert[std::stoul(line.substr(0, comma)) - 1];
      for (const int corner : of_face[std::stoul(line.substr(comma + 2)) - 1]) points.insert(tet[corner]);
      ++sides;
    }
    std::set<std::uint32_t> nodes;
    for (const std::string& line : sections.at("*NSET, NSET=" + group.name))
      for (const double number : numbers_in(line)) nodes.insert(static_cast<std::uint32_t>(number) - 1);
    CHECK(nodes == points);
  }
  CHECK(sides == mesh.tri_to_vert.size());
}

TEST_CASE(".inp of a surface has shells") {
  Mesh mesh = named_box();
  mesh.tet_to_vert.clear(), mesh.tet_to_entity.clear();
  const std::string text = written(mesh, ".inp");
  CHECK(text.find("*ELEMENT, TYPE=S3, ELSET=face_0_more") != std::string::npos);
  CHECK(text.find("*SURFACE") == std::string::npos);
}

TEST_CASE(".msh 2.2: triangles of a face with one region point out of it") {
  const TemporaryFolder folder;
  const Mesh mesh = with_turned_face();
  write_mesh(mesh, folder / "a.msh", WriteOptions{.msh_2_2 = true, .text = true});
  const Mesh read = read_mesh(folder / "a.msh");
  double volume = 0;
  for (std::size_t t = 0; t < read.tri_to_vert.size(); ++t) {
    const auto& [a, b, c] = read.tri_to_vert[t];
    const FaceSides& sides = mesh.face_to_sides[read.tri_to_entity[t]];
    if (sides.front.valid() && sides.back.valid()) continue;
    volume += signed_volume({read.points[a], read.points[b], read.points[c]}, {});
  }
  CHECK(volume == Approx(24));
}

TEST_CASE(".su2 has cells, points and markers that point outwards") {
  const Mesh mesh = with_turned_face();
  const std::string text = written(mesh, ".su2");
  CHECK(text.find("NDIME= 3\nNELEM= " + std::to_string(mesh.tet_to_vert.size())) != std::string::npos);
  const std::size_t markers = text.find("NMARK= ");
  CHECK(std::stoul(text.substr(markers + 7)) == 10);  // two faces of each side but two, and not the one in the middle
  std::istringstream stream(text.substr(markers));
  double volume = 0;
  for (std::string line; std::getline(stream, line);) {
    const std::vector<double> numbers = numbers_in(line);
    if (numbers.size() != 4 || numbers[0] != 5) continue;
    std::vector<Vec3> polygon;
    for (std::size_t i = 1; i < 4; ++i) polygon.push_back(mesh.points[static_cast<std::size_t>(numbers[i])]);
    volume += signed_volume(polygon, {});
  }
  CHECK(volume == Approx(24));
}

TEST_CASE(".bdf has fields of eight and sixteen characters") {
  const Mesh mesh = named_box();
  const std::string text = written(mesh, ".bdf");
  std::istringstream stream(text);
  std::map<std::string, std::size_t> cards;
  for (std::string line; std::getline(stream, line);) {
    CHECK(line.size() <= 80);
    ++cards[line.substr(0, line.find(' '))];
    if (!line.starts_with("CTETRA")) continue;
    REQUIRE(line.size() == 7 * 8);
    const std::size_t element = std::stoul(line.substr(8, 8)) - 1;
    for (std::size_t i = 0; i < 4; ++i)
      CHECK(std::stoul(line.substr(24 + 8 * i, 8)) == mesh.tet_to_vert[element][i] + 1);
  }
  CHECK(cards["GRID*"] == mesh.points.size());
  CHECK(cards["CTETRA"] == mesh.tet_to_vert.size());
  CHECK(cards["CTRIA3"] == mesh.tri_to_vert.size());
  CHECK(cards["PSOLID"] == 2);
  CHECK(text.find("$ region steel\n") != std::string::npos);
}

TEST_CASE(".msh 2.2 as text is read back the same") {
  const TemporaryFolder folder;
  for (const Mesh& mesh : {named_box(), test::make_mixed_box(4, 3, 5, 7, true)}) {
    write_mesh(mesh, folder / "a.msh", WriteOptions{.msh_2_2 = true, .text = true});
    const Mesh read = read_mesh(folder / "a.msh");
    CHECK(test::same_points(read, mesh));
    CHECK(read.tet_to_vert == mesh.tet_to_vert);
    CHECK(read.tet_to_entity == mesh.tet_to_entity);
    CHECK(read.prism_to_vert == mesh.prism_to_vert);
    CHECK(read.tri_to_entity == mesh.tri_to_entity);
    CHECK(read.edge_to_vert == mesh.edge_to_vert);
  }
}

TEST_CASE(".msh 2.2: no two physical groups have one number, whatever their dimension, and names come back") {
  Mesh mesh = named_box();
  mesh.entities[2][1].group = mesh.entities[2][3].group = "the load";
  std::istringstream text(written(mesh, ".msh", {.msh_2_2 = true, .text = true}));
  std::string line;
  while (std::getline(text, line) && line != "$PhysicalNames") {}
  std::getline(text, line);
  std::set<int> numbers;
  std::size_t count = 0;
  while (std::getline(text, line) && line != "$EndPhysicalNames") {
    std::istringstream words(line);
    int dim = 0, number = 0;
    words >> dim >> number;
    numbers.insert(number);
    ++count;
  }
  CHECK(count > 20);
  CHECK(numbers.size() == count);
  const TemporaryFolder folder;
  for (const bool is_text : {false, true}) {
    write_mesh(mesh, folder / "a.msh", WriteOptions{.msh_2_2 = true, .text = is_text});
    const Mesh read = read_mesh(folder / "a.msh");
    CHECK(read.entities[3].at(1).name == "steel");
    CHECK(read.entities[2].at(1).name == "the_load");
    CHECK(read.entities[2].at(3).name == "the_load");
    CHECK(read.entities[1].at(4).name == "edge_5");
  }
}

TEST_CASE(".msh 2.2 has a physical group for every entity, and records of known size when binary") {
  const Mesh mesh = named_box();
  const std::string text = written(mesh, ".msh", {.msh_2_2 = true, .text = true});
  CHECK(text.find("2 11 \"") != std::string::npos);
  CHECK(text.find("3 13 \"steel\"") != std::string::npos);  // behind eleven faces and the other region
  const std::string binary = written(mesh, ".msh", {.msh_2_2 = true, .text = false});
  CHECK(binary.starts_with("$MeshFormat\n2.2 1 8\n"));
  const std::size_t nodes = binary.find("$Nodes\n"), end = binary.find("\n$EndNodes");
  const std::string count = std::to_string(mesh.points.size()) + "\n";
  CHECK(end - nodes == 7 + count.size() + 28 * mesh.points.size());
}

TEST_CASE("formats that are only written are not read, and those of solvers are known by their extension") {
  for (const char* name : {"a.bdf", "a.exo", "a.foam", "case/polyMesh"}) {
    CHECK(is_writable_mesh_format(name));
    CHECK_FALSE(is_mesh_extension(name));
    CHECK(error_of([&] { static_cast<void>(read_mesh(name)); }).code == ErrorCode::InvalidArgument);
  }
  CHECK(writable_mesh_extensions().find(".foam") != std::string::npos);
  CHECK(known_mesh_extensions().find(".bdf") == std::string::npos);
  for (const char* name : {"a.bdf", "a.exo", "a.inp", "a.su2", "a.foam"}) CHECK(holds_solver_names(name));
  for (const char* name : {"a.vtu", "a.mesh", "a.msh"}) CHECK_FALSE(holds_solver_names(name));
  CHECK(holds_solver_names("a.msh", {.msh_2_2 = true}));
}
