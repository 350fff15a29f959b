// A mesh in parts as the processors of an OpenFOAM case: both sides of every part boundary fit, and all parts name the
// same patches and zones.
#include <array>
#include <catch2/catch.hpp>
#include <fstream>
#include <map>
#include <sstream>

#include "core/mesh/mesh_access.hpp"
#include "tests/support/error_of.hpp"
#include "tests/support/mixed_mesh.hpp"
#include "tests/support/temporary_folder.hpp"
#include "tests/threading/communicators.hpp"
#include "tetloom/partition.hpp"
#include "tetloom/tasks.hpp"
#include "threading/parts/group_names.hpp"

using namespace tetloom;
using tetloom::test::error_of;
using tetloom::test::file_content;
using tetloom::test::TemporaryFolder;
namespace fs = std::filesystem;

namespace {

struct Patch {
  std::string name, type;
  std::size_t count = 0, first = 0;
  int neighbour = -1;
};

/// The mesh of a processor.
struct Processor {
  std::vector<Vec3> points;
  std::vector<std::vector<std::size_t>> faces;
  std::vector<std::size_t> owner, neighbour;
  std::vector<Patch> patches;
  std::string cell_zones, face_zones;

  Vec3 area_of(std::size_t face) const {
    Vec3 area;
    const auto& verts = faces[face];
    for (std::size_t k = 2; k < verts.size(); ++k)
      area += 0.5 * cross(points[verts[k - 1]] - points[verts[0]], points[verts[k]] - points[verts[0]]);
    return area;
  }
};

/// The lines between the brackets of a list, without theirs.
std::vector<std::vector<double>> list_in(const fs::path& path) {
  std::istringstream stream(file_content(path));
  std::vector<std::vector<double>> items;
  std::string line;
  while (std::getline(stream, line) && line != "(") {}
  while (std::getline(stream, line) && line != ")") {
    for (char& c : line)
      if (c == '(' || c == ')') c = ' ';
    std::istringstream numbers(line);
    items.emplace_back();
    for (double number = 0; numbers >> number;) items.back().push_back(number);
  }
  return items;
}

std::vector<Patch> patches_in(const fs::path& path) {
  std::istringstream stream(file_content(path));
  std::string word, last;
  while (stream >> word && word != "(") {}
  std::vector<Patch> patches;
  while (stream >> word && word != ")") {
    if (word == "{") patches.push_back({last, {}, 0, 0, -1});
    if (word == "type") {
      stream >> patches.back().type;
      patches.back().type.pop_back();  // the semicolon
    }
    if (word == "nFaces") stream >> patches.back().count;
    if (word == "startFace") stream >> patches.back().first;
    if (word == "neighbProcNo") stream >> patches.back().neighbour;
    last = word;
  }
  return patches;
}

Processor read_processor(const fs::path& folder) {
  Processor processor;
  for (const auto& x : list_in(folder / "points")) processor.points.push_back({x.at(0), x.at(1), x.at(2)});
  for (const auto& face : list_in(folder / "faces")) {
    processor.faces.emplace_back(face.begin() + 1, face.end());
    REQUIRE(static_cast<double>(processor.faces.back().size()) == face[0]);
  }
  for (const auto& cell : list_in(folder / "owner")) processor.owner.push_back(static_cast<std::size_t>(cell.at(0)));
  for (const auto& cell : list_in(folder / "neighbour"))
    processor.neighbour.push_back(static_cast<std::size_t>(cell.at(0)));
  processor.patches = patches_in(folder / "boundary");
  processor.cell_zones = file_content(folder / "cellZones");
  processor.face_zones = file_content(folder / "faceZones");
  return processor;
}

Mesh make_named(bool mixed) {
  Mesh mesh = mixed ? test::make_mixed_box(4, 3, 5, 7, true) : test::make_tet_box(6, 4, 3, 3, true);
  mesh.entities[2].resize(mesh.face_to_sides.size());
  mesh.entities[2][0].name = "in let";
  mesh.entities[2][1].group = mesh.entities[2][2].group = "walls";
  mesh.entities[3].resize(2);
  mesh.entities[3][1].name = "steel";
  return mesh;
}

/// Triangles and quadrilaterals between the two regions.
std::size_t interface_count(const Mesh& mesh) {
  std::size_t count = 0;
  for (const auto* entities : {&mesh.tri_to_entity, &mesh.quad_to_entity})
    for (const std::uint32_t face : *entities)
      count += mesh.face_to_sides[face].front.valid() && mesh.face_to_sides[face].back.valid() ? 1 : 0;
  return count;
}

PartitionedMesh dealt_parts(const Mesh& mesh, std::size_t count, Communicator& communicator, const TaskRunner& runner) {
  PartitionedMesh parts = distribute_mesh(mesh, communicator);
  BalanceOptions options;
  options.part_count = count;
  deal_cells(parts, options, runner);
  return parts;
}

fs::path mesh_of(const fs::path& folder, std::size_t part) {
  return folder / ("processor" + std::to_string(part)) / "constant" / "polyMesh";
}

std::vector<Processor> read_case(const fs::path& folder, std::size_t count) {
  std::vector<Processor> all;
  for (std::size_t part = 0; part < count; ++part) all.push_back(read_processor(mesh_of(folder, part)));
  return all;
}

/// Names of the patches that are not those of processors.
std::vector<std::string> own_patches(const Processor& processor) {
  std::vector<std::string> names;
  for (const Patch& patch : processor.patches)
    if (patch.type == "patch") names.push_back(patch.name);
  return names;
}

/// Volumes of the cells, whose faces have to close.
double closed_volume(const Processor& processor) {
  std::map<std::size_t, Vec3> areas;
  double volume = 0;
  for (std::size_t f = 0; f < processor.faces.size(); ++f) {
    const Vec3 area = processor.area_of(f);
    areas[processor.owner[f]] += area;
    if (f < processor.neighbour.size()) {
      CHECK(processor.owner[f] < processor.neighbour[f]);
      areas[processor.neighbour[f]] -= area;
    } else {
      const auto& verts = processor.faces[f];
      for (std::size_t k = 2; k < verts.size(); ++k)
        volume +=
            dot(processor.points[verts[0]], cross(processor.points[verts[k - 1]], processor.points[verts[k]])) / 6;
    }
  }
  for (const auto& [cell, area] : areas) CHECK(norm(area) < 1e-12);
  return volume;
}

void check_sides(const std::vector<Processor>& all, std::size_t part) {
  const auto shared = std::ranges::count(all[part].patches, "processor", &Patch::type);
  CHECK((shared > 0) == (all.size() > 1));
  for (const Patch& patch : all[part].patches) {
    if (patch.type != "processor") continue;
    const Processor& other = all.at(static_cast<std::size_t>(patch.neighbour));
    const auto twin =
        std::ranges::find_if(other.patches, [&](const Patch& p) { return p.neighbour == static_cast<int>(part); });
    REQUIRE(twin != other.patches.end());
    REQUIRE(twin->count == patch.count);
    for (std::size_t i = 0; i < patch.count; ++i) {
      const auto &mine = all[part].faces[patch.first + i], &theirs = other.faces[twin->first + i];
      REQUIRE(mine.size() == theirs.size());
      for (std::size_t k = 0; k < mine.size(); ++k)  // the other way round from the same vertex
        CHECK(distance(all[part].points[mine[k]], other.points[theirs[(mine.size() - k) % mine.size()]]) == 0);
    }
  }
}

}  // namespace

TEST_CASE("processors of OpenFOAM: both sides of part boundaries fit, and patches and zones are the same in all") {
  const auto communicator = make_communicator();
  const TaskRunner runner(2);
  for (const bool mixed : {false, true})
    for (const std::size_t count : {1u, 2u, 5u}) {
      CAPTURE(mixed, count);
      const TemporaryFolder folder;
      const Mesh whole = make_named(mixed);
      write_parts(dealt_parts(whole, count, *communicator, runner), folder / "box.foam", runner);
      const std::vector<Processor> all = read_case(folder / "box.foam", count);
      double volume = 0;
      std::size_t cells = 0, boundary = 0;
      for (std::size_t part = 0; part < count; ++part) {
        volume += closed_volume(all[part]);
        check_sides(all, part);
        CHECK(own_patches(all[part]) == own_patches(all[0]));
        for (const char* zone : {"steel\n{", "region_1\n{"})
          CHECK(all[part].cell_zones.find(zone) != std::string::npos);
        CHECK(all[part].face_zones.find("}\n\n1\n(\n") != std::string::npos);
        cells += *std::ranges::max_element(all[part].owner) + 1;
        for (const Patch& patch : all[part].patches)
          if (patch.type == "patch") boundary += patch.count;
      }
      CHECK(volume == Approx(mixed ? 60 : 72));
      CHECK(cells == cell_count(whole));
      CHECK(boundary == surface_count(whole) - interface_count(whole));
      const auto names = own_patches(all[0]);
      CHECK(std::ranges::count(names, "in_let") == 1);
      CHECK(std::ranges::count(names, "walls") == 1);
      CHECK(file_content(folder / "box.foam/system/decomposeParDict")
                .find("numberOfSubdomains " + std::to_string(count) + ";") != std::string::npos);
    }
}

TEST_CASE("processors of OpenFOAM: files do not depend on threads, and those of more parts are not left behind") {
  const auto communicator = make_communicator();
  const TemporaryFolder folder;
  const Mesh whole = make_named(true);
  for (const int threads : {1, 3}) {
    const TaskRunner runner(threads);
    const fs::path path = folder / (std::to_string(threads) + ".foam");
    for (int again = 0; again < 2; ++again) write_parts(dealt_parts(whole, 3, *communicator, runner), path, runner);
  }
  for (std::size_t part = 0; part < 3; ++part)
    for (const char* name : {"points", "faces", "owner", "neighbour", "boundary", "cellZones", "faceZones"})
      CHECK(file_content(mesh_of(folder / "1.foam", part) / name) ==
            file_content(mesh_of(folder / "3.foam", part) / name));
  const TaskRunner runner(2);
  const PartitionedMesh two = dealt_parts(whole, 2, *communicator, runner);
  const Diagnostic refused = error_of([&] { write_parts(two, folder / "1.foam", runner); });
  CHECK(refused.code == ErrorCode::OutputFailed);
  CHECK(refused.message.find("processor2") != std::string::npos);
}

TEST_CASE("processors of OpenFOAM: a folder with somebody's files is left as it was, and so are the others") {
  const auto communicator = make_communicator();
  const TaskRunner runner(2);
  const TemporaryFolder folder;
  const PartitionedMesh parts = dealt_parts(make_named(false), 2, *communicator, runner);
  write_parts(parts, folder / "a.foam", runner);
  const std::string before = file_content(mesh_of(folder / "a.foam", 0) / "points");
  std::ofstream(mesh_of(folder / "a.foam", 1) / "notes.txt") << "mine";
  CHECK(error_of([&] { write_parts(parts, folder / "a.foam", runner); }).code == ErrorCode::OutputFailed);
  CHECK(file_content(mesh_of(folder / "a.foam", 0) / "points") == before);
  CHECK(file_content(mesh_of(folder / "a.foam", 1) / "notes.txt") == "mine");
}

TEST_CASE("names of groups in parts are those of the whole mesh") {
  const auto communicator = make_communicator();
  const TaskRunner runner(2);
  const Mesh whole = make_named(true);
  const PartitionedMesh parts = dealt_parts(whole, 4, *communicator, runner);
  const detail::GroupNames names = detail::gather_group_names(parts);
  const auto listed = detail::list_names(names.groups, names.entities), expected = solver_names(whole);
  REQUIRE(listed.size() == expected.size());
  for (std::size_t i = 0; i < listed.size(); ++i) {
    CHECK(listed[i].entity == expected[i].entity);
    CHECK(listed[i].original == expected[i].original);
    CHECK(listed[i].sanitised == expected[i].sanitised);
  }
}
