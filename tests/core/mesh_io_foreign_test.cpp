// Other programs as judges: what they read of our files, and what we read of theirs.
#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstdlib>
#include <map>
#include <sstream>

#include "tests/core/mesh_fixtures.hpp"
#include "tests/core/mesh_io_support.hpp"
#include "tetloom/check.hpp"
#include "tetloom/io.hpp"

using namespace tetloom;
using test::file_content;
using test::has_meshio;
using test::succeeds;
using test::TemporaryFolder;

namespace {

Mesh decorated_box() {
  Mesh mesh = test::make_box(4, 3, 3, true, 1.0 / 3);
  test::jitter(mesh, 0.05, 42);
  test::decorate(mesh);
  return mesh;
}

/// Runs a Python program with arguments; its output on success.
std::string python(const TemporaryFolder& folder, const std::string& program, const std::string& arguments) {
  test::write_file(folder / "program.py", program);
  const std::string command = "/usr/bin/python3 '" + (folder / "program.py").string() + "' " + arguments;
  const bool fine = succeeds(command, folder / "log");
  INFO(file_content(folder / "log"));
  REQUIRE(fine);
  return file_content(folder / "log");
}

std::string in_quotes(const std::filesystem::path& path) {
  std::string text("'");
  text += path.string();
  return text += '\'';
}

// Prints points and elements of a mesh as meshio sees them, sorted, so that the order of blocks does not matter.
constexpr const char* kDump = R"(
import sys, meshio, numpy as np
m = meshio.read(sys.argv[1])
print('points', len(m.points), ' '.join(float(x).hex() for x in m.points.ravel()))
for kind in ('line', 'triangle', 'tetra'):
    cells = [tuple(int(v) for v in row) for block in m.cells if block.type == kind for row in block.data]
    print(kind, len(cells), ' '.join(str(v) for row in sorted(cells) for v in row))
)";

std::map<std::string, std::string> parse_dump(const std::string& text) {
  std::map<std::string, std::string> lines;
  std::istringstream stream(text);
  for (std::string line; std::getline(stream, line);) lines[line.substr(0, line.find(' '))] = line;
  return lines;
}

template <class Elements>
std::string sorted_line(const std::string& kind, Elements elements) {
  std::sort(elements.begin(), elements.end());
  std::string line = kind + " " + std::to_string(elements.size());
  for (const auto& element : elements)
    for (const std::uint32_t v : element) (line += ' ') += std::to_string(v);
  return line;
}

double number_in(const std::string& json, const std::string& key) {
  const std::size_t place = json.find("\"" + key + "\": ");
  REQUIRE(place != std::string::npos);
  return std::stod(json.substr(place + key.size() + 4));
}

}  // namespace

TEST_CASE("meshio reads the same points and elements from every format") {
  if (!has_meshio()) return;
  const TemporaryFolder folder;
  const Mesh mesh = decorated_box();
  for (const char* extension : {".vtu", ".mesh", ".meshb", ".msh"}) {
    INFO(extension);
    const auto path = folder / test::joined("mesh", extension);
    write_mesh(mesh, path);
    auto lines = parse_dump(python(folder, kDump, in_quotes(path)));
    if (std::string(extension) != ".msh") {
      // In MSH files nodes come by entity, and meshio numbers them as they come.
      CHECK(lines["line"] == sorted_line("line", mesh.edge_to_vert));
      CHECK(lines["triangle"] == sorted_line("triangle", mesh.tri_to_vert));
      CHECK(lines["tetra"] == sorted_line("tetra", mesh.tet_to_vert));
      std::istringstream stream(lines["points"]);
      std::string word;
      stream >> word >> word;
      bool same = true;
      for (const Vec3& point : mesh.points)
        for (int axis = 0; axis < 3; ++axis) {
          stream >> word;
          same &= std::strtod(word.c_str(), nullptr) == point[axis];
        }
      CHECK(same);
    }
    CHECK(lines["tetra"].starts_with("tetra " + std::to_string(mesh.tet_to_vert.size()) + " "));
  }
  write_mesh(mesh, folder / "mesh.stl");
  CHECK(parse_dump(python(folder, kDump, in_quotes(folder / "mesh.stl")))["triangle"].starts_with(
      "triangle " + std::to_string(mesh.tri_to_vert.size()) + " "));
}

TEST_CASE("meshio sees the regions and faces of every format") {
  if (!has_meshio()) return;
  const TemporaryFolder folder;
  const Mesh mesh = decorated_box();
  const std::array<std::array<std::string, 2>, 4> cases{
      {{".vtu", "entity_tag"}, {".msh", "gmsh:physical"}, {".mesh", "medit:ref"}, {".meshb", "medit:ref"}}};
  for (const auto& [extension, key] : cases) {
    INFO(extension);
    write_mesh(mesh, folder / test::joined("mesh", extension));
    const std::string counts = python(folder, R"(
import sys, meshio, numpy as np
m = meshio.read(sys.argv[1])
for kind in ('triangle', 'tetra'):
    tags = np.concatenate([d for b, d in zip(m.cells, m.cell_data[sys.argv[2]]) if b.type == kind]).astype(int)
    print(kind, *np.bincount(tags.ravel()))
)",
                                      in_quotes(folder / test::joined("mesh", extension)) + " " + key);
    std::vector<std::size_t> triangles(mesh.face_to_sides.size() + 1), tets(3);
    for (const std::uint32_t face : mesh.tri_to_entity) ++triangles[face + 1];
    for (const std::uint32_t region : mesh.tet_to_entity) ++tets[region + 1];
    std::ostringstream expected;
    expected << "triangle";
    for (const std::size_t count : triangles) expected << ' ' << count;
    expected << "\ntetra";
    for (const std::size_t count : tets) expected << ' ' << count;
    CHECK_THAT(counts, Catch::Contains(expected.str()));
  }
}

TEST_CASE("Gmsh opens our MSH files without a warning and keeps what is in them") {
  if (!succeeds("gmsh --version")) {
    std::cout << "gmsh is not installed: skipped\n";
    return;
  }
  const TemporaryFolder folder;
  const Mesh mesh = decorated_box();
  Mesh bare = mesh;
  bare.tet_to_entity.assign(bare.tet_to_vert.size(), ModelRegionId::kNone);
  bare.tri_to_vert.clear(), bare.tri_to_entity.clear();
  bare.edge_to_vert.clear(), bare.edge_to_entity.clear();
  bare.point_to_entity.assign(bare.points.size(), {});
  const std::array<std::pair<std::string, const Mesh*>, 2> cases{{{"full", &mesh}, {"bare", &bare}}};
  for (const auto& [name, original] : cases) {
    INFO(name);
    const auto path = folder / (name + ".msh"), again = folder / (name + "-gmsh.msh");
    write_mesh(*original, path);
    CHECK(succeeds("gmsh " + in_quotes(path) + " -check -v 5", folder / "check"));
    const bool saved =
        succeeds("gmsh " + in_quotes(path) + " -0 -save_all -format msh41 -o " + in_quotes(again), folder / "log");
    INFO(file_content(folder / "log"));
    REQUIRE(saved);
    CHECK_THAT(file_content(folder / "log"), !Catch::Contains("Warning") && !Catch::Contains("Error"));
    const Mesh read = read_mesh(again);
    CHECK(read.points.size() == original->points.size());
    CHECK(read.tri_to_vert.size() == original->tri_to_vert.size());
    CHECK(read.tet_to_vert.size() == original->tet_to_vert.size());
    CHECK(compute_quality(read).tets.volume == Approx(compute_quality(*original).tets.volume));
    CHECK(validate_mesh(read).valid());
    if (original == &mesh) CHECK(read.entities[3].at(1).name == "steel");
  }
}

TEST_CASE("VTU files of meshio come back in every encoding") {
  if (!has_meshio()) return;
  const TemporaryFolder folder;
  const Mesh mesh = decorated_box();
  write_mesh(mesh, folder / "ours.vtu");
  for (const char* how : {"binary=False", "binary=True, compression=None", "binary=True, compression='zlib'",
                          "binary=True, compression='zlib', header_type='UInt64'"}) {
    INFO(how);
    python(folder,
           std::string("import sys, meshio\nm = meshio.read(sys.argv[1])\nm.field_data = {}\n"
                       "meshio.vtu.write(sys.argv[2], m, ") +
               how + ")\n",
           in_quotes(folder / "ours.vtu") + " " + in_quotes(folder / "theirs.vtu"));
    const Mesh read = read_mesh(folder / "theirs.vtu");
    CHECK(read.tet_to_vert == mesh.tet_to_vert);
    CHECK(read.tri_to_vert == mesh.tri_to_vert);
    CHECK(read.tet_to_entity == mesh.tet_to_entity);
    CHECK(read.point_to_entity == mesh.point_to_entity);
    CHECK(read.points.size() == mesh.points.size());
    if (std::string(how) != "binary=False") CHECK(test::same_points(read, mesh));
  }
}

TEST_CASE("MSH files of meshio and Gmsh come back in every version") {
  if (!has_meshio()) return;
  const TemporaryFolder folder;
  const Mesh mesh = decorated_box();
  write_mesh(mesh, folder / "ours.vtu");
  for (const char* how : {"'2.2', binary=False", "'4.1', binary=False", "'4.1', binary=True"}) {
    INFO(how);
    python(folder,
           std::string(R"(
import sys, meshio, numpy as np
m = meshio.read(sys.argv[1])
tags = [np.asarray(d).ravel().astype(np.int32) for d in m.cell_data['entity_tag']]
point_data = {'gmsh:dim_tags': np.column_stack([m.point_data[k].ravel() for k in ('entity_dim', 'entity_tag')]).astype(np.int32)}
cells = []; out = []
for block, tag in zip(m.cells, tags):
    for t in np.unique(tag):
        cells.append((block.type, block.data[tag == t])); out.append(np.full((tag == t).sum(), t, np.int32))
m = meshio.Mesh(m.points, cells, point_data if sys.argv[3] == '4' else {}, {'gmsh:geometrical': out, 'gmsh:physical': out})
meshio.gmsh.write(sys.argv[2], m, )") +
               how + ")\n",
           in_quotes(folder / "ours.vtu") + " " + in_quotes(folder / "theirs.msh") + " " + how[1]);
    const Mesh read = read_mesh(folder / "theirs.msh");
    CHECK(test::same_points(read, mesh));
    CHECK(read.tet_to_vert.size() == mesh.tet_to_vert.size());
    CHECK(read.tri_to_vert.size() == mesh.tri_to_vert.size());
    CHECK(validate_mesh(read).valid());
    if (how[1] == '4') CHECK(read.point_to_entity == mesh.point_to_entity);
    CHECK(compute_quality(read).cells.regions.at(1).volume == Approx(compute_quality(mesh).cells.regions.at(1).volume));
  }
}

TEST_CASE("meshes that Gmsh makes are valid") {
  if (!succeeds("gmsh --version")) return;
  const TemporaryFolder folder;
  test::write_file(folder / "two.geo",
                   "SetFactory(\"OpenCASCADE\");\nBox(1) = {0,0,0, 1,1,1};\nBox(2) = {1,0,0, 1,1,1};\n"
                   "BooleanFragments{ Volume{1}; Delete; }{ Volume{2}; Delete; }\nMesh.MeshSizeMax = 0.3;\n"
                   "Physical Volume(\"left\", 7) = {1};\nPhysical Volume(\"right\", 9) = {2};\n");
  // MSH 2.2 keeps physical groups only without -save_all, and then nothing but the volumes.
  for (const char* how : {"-save_all -format msh41", "-save_all -format msh41 -bin", "-format msh22"}) {
    INFO(how);
    const auto path = folder / "two.msh";
    REQUIRE(succeeds("gmsh " + in_quotes(folder / "two.geo") + " -3 " + how + " -o " + in_quotes(path)));
    const Mesh mesh = read_mesh(path);
    const ValidationReport report = validate_mesh(mesh);
    for (const MeshProblem& problem : report.problems) INFO(problem.message);
    CHECK(report.valid());
    CHECK(report.interface_faces > 0);
    const TetQuality quality = compute_quality(mesh).tets;
    CHECK(quality.volume == Approx(2));
    CHECK(compute_quality(mesh).cells.regions.size() == 2);
    REQUIRE(mesh.entities[3].size() == 2);
    CHECK(mesh.entities[3][1].name == "right");
  }
  REQUIRE(succeeds("gmsh " + in_quotes(folder / "two.geo") + " -3 -save_all -format mesh -o " +
                   in_quotes(folder / "two.mesh")));
  const Mesh mesh = read_mesh(folder / "two.mesh");
  CHECK(compute_quality(mesh).tets.volume == Approx(2));
  CHECK(validate_mesh(mesh).valid());
}

TEST_CASE("the independent judge agrees about quality") {
  const std::string judge = std::string(TETLOOM_SHARED_DIR) + "/tools/quality.py";
  if (!has_meshio() || !std::filesystem::exists(judge)) {
    std::cout << "no judge in " << judge << ": skipped\n";
    return;
  }
  const TemporaryFolder folder;
  Mesh mesh = test::make_box(12, 10, 14, true, 0.1);
  test::jitter(mesh, 0.03, 5);
  const SizeField sizes = SizeField::uniform(0.12);
  const TetQuality ours = compute_quality(mesh, &sizes).tets;
  for (const char* extension : {".vtu", ".msh", ".mesh", ".meshb"}) {
    INFO(extension);
    const auto path = folder / test::joined("mesh", extension);
    write_mesh(mesh, path);
    REQUIRE(succeeds("/usr/bin/python3 " + in_quotes(judge) + " " + in_quotes(path) + " 0.12", folder / "log"));
    const std::string log = file_content(folder / "log");
    CHECK(number_in(log, "tets") == static_cast<double>(ours.count));
    CHECK(number_in(log, "inverted") == static_cast<double>(ours.inverted));
    CHECK(number_in(log, "volume") == Approx(ours.volume).margin(1e-5));
    CHECK(number_in(log, "min_dih") == Approx(ours.min_dihedral_deg).margin(2e-5));
    CHECK(number_in(log, "mean_ratio_mean") == Approx(ours.mean_ratio_mean).margin(1e-5));
    CHECK(number_in(log, "mean_ratio_p1") == Approx(ours.mean_ratio_p1).margin(1e-5));
    CHECK(number_in(log, "edges") == static_cast<double>(ours.edges.edges));
    CHECK(number_in(log, "edge_mean") == Approx(ours.edges.mean_length_ratio).margin(1e-5));
    CHECK(number_in(log, "0.707-1.414") == Approx(100 * ours.edges.in_band).margin(1e-3));
  }
}
