// Partitioned meshes go to files and come back, and files that do not fit together are refused with a place.
#include "tetloom/partition.hpp"
#include "tetloom/tasks.hpp"

#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <filesystem>
#include <fstream>
#include <functional>
#include <optional>

#include "core/io/mesh_piece.hpp"
#include "core/mesh/mesh_access.hpp"
#include "tests/core/file_size_limit.hpp"
#include "tests/support/error_of.hpp"
#include "tests/support/mixed_mesh.hpp"
#include "tests/support/temporary_folder.hpp"
#include "tests/threading/communicators.hpp"
#include "tetloom/check.hpp"
#include "tetloom/io.hpp"
#include "threading/comm/simulated_ranks.hpp"

using namespace tetloom;
using tetloom::test::error_of;
using tetloom::test::TemporaryFolder;
namespace fs = std::filesystem;

namespace {

Mesh make_case(bool mixed) {
  Mesh mesh = mixed ? test::make_mixed_box(4, 3, 5, 7, true) : test::make_tet_box(5, 4, 3, 3, true);
  MeshField places{"places & <more>", 3, {}};
  for (const Vec3& p : mesh.points) places.values.insert(places.values.end(), {p.x, p.y, p.z});
  mesh.point_fields = {places};
  MeshField numbers{"numbers", 1, {}};
  for (std::size_t i = 0; i < cell_count(mesh); ++i) numbers.values.push_back(1 + static_cast<double>(i % 7));
  mesh.cell_fields = {numbers};
  mesh.entities[2].resize(mesh.face_to_sides.size());
  for (std::size_t i = 0; i < mesh.entities[2].size(); i += 2)
    mesh.entities[2][i] = {"face " + std::to_string(i), Color{1, 0.5F, 0}, {}, 0};
  mesh.entities[3].resize(2);
  mesh.entities[3][1].name = "second";
  return mesh;
}

PartitionedMesh make_parts(const Mesh& mesh, std::size_t count, Communicator& communicator, const TaskRunner& runner) {
  PartitionedMesh parts = distribute_mesh(mesh, communicator);
  BalanceOptions options;
  options.part_count = count;
  migrate(parts, compute_destinations(parts, options, runner), count, runner);
  return parts;
}

std::string names_of(const Mesh& mesh) {
  std::string text;
  for (const auto& table : mesh.entities)
    for (const EntityAttributes& entity : table) text += entity.name + (entity.color ? "c;" : ";");
  for (const FaceSides& sides : mesh.face_to_sides)
    text += std::to_string(sides.front.value) + "|" + std::to_string(sides.back.value) + ";";
  return text;
}

/// Four parts of a box in `folder`/box.pvtu, and what reading them comes to after `damage`.
struct DamagedParts {
  TemporaryFolder folder;
  std::unique_ptr<Communicator> communicator = make_communicator();
  TaskRunner runner{2};

  explicit DamagedParts(bool mixed = false) {
    write_parts(make_parts(make_case(mixed), 4, *communicator, runner), folder / "box.pvtu", runner);
  }
  fs::path piece(int part) const { return folder / ("box/box_" + std::to_string(part) + ".vtu"); }
  void edit(int part, const std::function<void(MeshPiece&)>& change) const {
    MeshPiece piece_mesh = read_mesh_piece(piece(part));
    change(piece_mesh);
    write_mesh_piece(piece_mesh.mesh, piece_mesh.global_ids, piece(part));
  }
  void replace_in_list(const std::string& from, const std::string& to) const {
    std::string text = test::file_content(folder / "box.pvtu");
    REQUIRE(text.find(from) != std::string::npos);
    std::ofstream(folder / "box.pvtu") << text.replace(text.find(from), from.size(), to);
  }
  Diagnostic failure() {
    return error_of([&] { read_parts(folder / "box.pvtu", *communicator, runner); });
  }
  /// A vertex of part 1 that part 0 has too.
  std::size_t shared_vertex() const {
    const MeshPiece zero = read_mesh_piece(piece(0)), one = read_mesh_piece(piece(1));
    for (std::size_t i = 0; i < one.global_ids.size(); ++i)
      if (std::find(zero.global_ids.begin(), zero.global_ids.end(), one.global_ids[i]) != zero.global_ids.end())
        return i;
    FAIL("parts 0 and 1 do not touch");
    return 0;
  }
};

}  // namespace

TEST_CASE("parts come back from files as they were") {
  const auto communicator = make_communicator();
  const TaskRunner runner(2);
  for (const bool mixed : {false, true})
    for (const std::size_t count : {1u, 2u, 5u, 33u, 2000u})
      for (const char* name : {"box.pvtu", "box.msh"}) {
        CAPTURE(mixed, count, name);
        const TemporaryFolder folder;
        const Mesh whole = make_case(mixed);
        const PartitionedMesh parts = make_parts(whole, count, *communicator, runner);
        write_parts(parts, folder / name, runner);
        PartitionedMesh back = read_parts(folder / name, *communicator, runner);
        CHECK(folder.file_count() == (is_piece_list(name) ? 2 : 1));
        CHECK(is_partitioned_file(folder / name, *communicator));
        REQUIRE(back.part_count() == count);
        CHECK(validate_parts(back, runner).total == 0);
        const PartsFigures before = measure_parts(parts), after = measure_parts(back);
        CHECK(after.cut_faces == before.cut_faces);
        for (std::size_t part = 0; part < count; ++part)
          CHECK(after.parts[part].elements == before.parts[part].elements);
        const Mesh gathered = gather_mesh(back, runner);
        CHECK(mesh_digest(gathered) == mesh_digest(whole));
        CHECK(field_digest(gathered) == field_digest(whole));
        if (is_piece_list(name)) CHECK(names_of(gathered) == names_of(whole));
      }
}

TEST_CASE("parts that are written again are the same, byte for byte") {
  const auto communicator = make_communicator();
  const TemporaryFolder folder;
  for (const int threads : {1, 3}) {
    const TaskRunner runner(threads);
    write_parts(make_parts(make_case(true), 5, *communicator, runner), folder / "a.pvtu", runner);
    fs::create_directories(folder / std::to_string(threads));
    fs::copy(folder / "a", folder / std::to_string(threads), fs::copy_options::recursive);
  }
  for (int part = 0; part < 5; ++part) {
    const std::string name = "/a_" + std::to_string(part) + ".vtu";
    CHECK(test::file_content(folder / ("1" + name)) == test::file_content(folder / ("3" + name)));
  }
}

TEST_CASE("a file with one mesh of tets is read by slices, a part for each rank") {
  const TemporaryFolder folder;
  Mesh whole = make_case(false);
  for (const std::string name : {"box.vtu", "box.msh", "box.meshb"}) {
    if (name == "box.meshb") whole.point_fields.clear(), whole.cell_fields.clear();  // there is no room for them
    write_mesh(whole, folder / name);
    const Mesh read = read_mesh(folder / name);
    for (const int ranks : {1, 2, 3, 5}) {
      CAPTURE(name, ranks);
      bool fits = false;
      Mesh gathered;
      std::uint64_t points = 0;
      on_simulated_ranks(ranks, [&](Communicator& communicator) {
        const TaskRunner runner(1);
        std::optional<SlicedMesh> sliced = read_slices(folder / name, communicator, runner);
        if (!sliced) throw Error(ErrorCode::Internal, "no slices");
        const bool valid = validate_parts(sliced->mesh, runner).valid();
        Mesh all = gather_mesh(sliced->mesh, runner);
        if (communicator.rank() != 0) return;
        fits = valid, gathered = std::move(all), points = sliced->points;
      });
      CHECK(fits);
      CHECK(points == read.points.size());
      CHECK(gathered.points == read.points);
      CHECK(gathered.tet_to_vert == read.tet_to_vert);
      CHECK(mesh_digest(gathered) == mesh_digest(read));
      CHECK(field_digest(gathered) == field_digest(read));
      CHECK(names_of(gathered) == names_of(read));
    }
  }
}

TEST_CASE("a file that cannot be read by slices is left to others on all ranks, or refused on all") {
  const TemporaryFolder folder;
  Mesh lost = make_case(false);
  lost.point_fields.clear(), lost.cell_fields.clear();
  const auto last = static_cast<std::uint32_t>(lost.points.size() - 1);
  lost.tri_to_vert.push_back({0, 1, last}), lost.tri_to_entity.push_back(0);
  write_mesh(lost, folder / "lost.meshb");
  write_mesh(test::make_mixed_box(4, 3, 5, 7, true), folder / "mixed.vtu");
  write_mesh(make_case(false), folder / "box.su2");
  for (const char* name : {"lost.meshb", "mixed.vtu", "box.su2", "missing.vtu"}) {
    CAPTURE(name);
    std::array<int, 3> outcomes{};  // by rank: 1 nothing, 2 unreadable
    on_simulated_ranks(3, [&](Communicator& communicator) {
      int& outcome = outcomes[static_cast<std::size_t>(communicator.rank())];
      try {
        outcome = read_slices(folder / name, communicator, TaskRunner(1)) ? 3 : 1;
      } catch (const Error& error) {
        outcome = error.code() == ErrorCode::InputUnreadable ? 2 : 4;
      }
    });
    CHECK(outcomes == (std::string(name) == "missing.vtu" ? std::array{2, 2, 2} : std::array{1, 1, 1}));
  }
}

TEST_CASE("a partitioned MSH file is a mesh like any other to whom the parts are all the same") {
  const auto communicator = make_communicator();
  const TaskRunner runner(2);
  const TemporaryFolder folder;
  const Mesh whole = make_case(true);
  write_parts(make_parts(whole, 5, *communicator, runner), folder / "a.msh", runner);
  const Mesh mesh = read_mesh(folder / "a.msh");
  CHECK(mesh_digest(mesh) == mesh_digest(whole));
  CHECK(field_digest(mesh) == field_digest(whole));
  write_mesh(whole, folder / "plain.msh");
  CHECK_FALSE(is_partitioned_file(folder / "plain.msh", *communicator));
  CHECK(read_parts(folder / "plain.msh", *communicator, runner).part_count() == 1);
}

TEST_CASE("pieces are meshes of their own, whose global ids are no field") {
  const DamagedParts parts;
  const Mesh piece = read_mesh(parts.piece(2));
  CHECK(piece.point_fields.size() == 1);
  CHECK(cell_count(piece) > 0);
}

TEST_CASE("global ids keep all of their 63 bits") {
  const TemporaryFolder folder;
  const Mesh mesh = test::make_tet_box(1, 1, 1);
  std::vector<std::uint64_t> ids(mesh.points.size());
  for (std::size_t i = 0; i < ids.size(); ++i) ids[i] = (std::uint64_t{1} << 62) + 1 + i;
  write_mesh_piece(mesh, ids, folder / "a.vtu");
  CHECK(read_mesh_piece(folder / "a.vtu").global_ids == ids);
  ids[3] = std::uint64_t{1} << 63;
  CHECK(error_of([&] { write_mesh_piece(mesh, ids, folder / "b.vtu"); }).code == ErrorCode::InvalidArgument);
}

TEST_CASE("files that are missing or cut off are named") {
  DamagedParts parts;
  SECTION("missing") { fs::remove(parts.piece(2)); }
  SECTION("cut off") { fs::resize_file(parts.piece(2), fs::file_size(parts.piece(2)) / 2); }
  SECTION("empty") { fs::resize_file(parts.piece(2), 0); }
  const Diagnostic failure = parts.failure();
  CHECK(failure.code == ErrorCode::InputUnreadable);
  CHECK_THAT(failure.message, Catch::Contains("box_2.vtu"));
}

TEST_CASE("lists that are damaged, or made by others, are refused") {
  DamagedParts parts;
  SECTION("no list") { std::ofstream(parts.folder / "box.pvtu") << "junk"; }
  SECTION("cut off") { fs::resize_file(parts.folder / "box.pvtu", 300); }
  SECTION("a piece twice") { parts.replace_in_list("box_3.vtu", "box_1.vtu"); }
  SECTION("a piece less") { parts.replace_in_list("<Piece Source=\"box/box_3.vtu\"", "<Other"); }
  SECTION("exchanged pieces") {
    fs::rename(parts.piece(0), parts.folder / "aside");
    fs::rename(parts.piece(1), parts.piece(0));
    fs::rename(parts.folder / "aside", parts.piece(1));
    parts.edit(1, [](MeshPiece& piece) { piece.mesh.cell_fields.clear(); });
  }
  SECTION("no global ids") { parts.replace_in_list("\"global_id\"", "\"GlobalNodeId\""); }
  const Diagnostic failure = parts.failure();
  CHECK((failure.code == ErrorCode::InputUnreadable || failure.code == ErrorCode::InputUnsuitable));
  CHECK_THAT(failure.message, Catch::Contains("box"));
}

TEST_CASE("pieces that do not fit each other are refused with a point") {
  DamagedParts parts(GENERATE(false, true));
  const std::size_t vertex = parts.shared_vertex();
  SECTION("a point that has moved") {
    parts.edit(1, [&](MeshPiece& piece) { piece.mesh.points[vertex].x += 1e-12; });
  }
  SECTION("another classification") {
    parts.edit(1, [&](MeshPiece& piece) { piece.mesh.point_to_entity[vertex] = ModelEntity(3, 1); });
  }
  SECTION("another global id") {
    parts.edit(1, [&](MeshPiece& piece) { piece.global_ids[vertex] = 123'456'789; });
  }
  SECTION("a global id twice") {
    parts.edit(1, [&](MeshPiece& piece) { piece.global_ids[vertex] = piece.global_ids[vertex == 0 ? 1 : vertex - 1]; });
  }
  const Diagnostic failure = parts.failure();
  CHECK(failure.code == ErrorCode::InputUnsuitable);
  CHECK_THAT(failure.message, Catch::Contains("box_"));
  CHECK(failure.point.has_value());
}

TEST_CASE("without boundary elements, pieces that have come apart are noticed by their totals") {
  const auto communicator = make_communicator();
  const TaskRunner runner(2);
  const TemporaryFolder folder;
  Mesh mesh = test::make_tet_box(3, 3, 3);
  mesh.tri_to_vert.clear(), mesh.tri_to_entity.clear();
  mesh.edge_to_vert.clear(), mesh.edge_to_entity.clear();
  write_parts(make_parts(mesh, 2, *communicator, runner), folder / "a.pvtu", runner);
  MeshPiece piece = read_mesh_piece(folder / "a/a_1.vtu");
  for (std::uint64_t& id : piece.global_ids) id += 1000;
  write_mesh_piece(piece.mesh, piece.global_ids, folder / "a/a_1.vtu");
  const Diagnostic failure = error_of([&] { read_parts(folder / "a.pvtu", *communicator, runner); });
  CHECK(failure.code == ErrorCode::InputUnsuitable);
  CHECK_THAT(failure.message, Catch::Contains("a.pvtu"));
}

TEST_CASE("an output that cannot be completed leaves the old one as it was") {
  DamagedParts parts;
  const PartitionedMesh mesh = make_parts(make_case(false), 7, *parts.communicator, parts.runner);
  CancelToken cancel;
  cancel.cancel();
  SECTION("cancelled") {
    const auto write = [&] { write_parts(mesh, parts.folder / "box.pvtu", parts.runner, &cancel); };
    CHECK(error_of(write).code == ErrorCode::Cancelled);
  }
  SECTION("the disk is full when the largest piece is written") {
    // As large as they will be, and none that would fit: the last one of all sizes fails beside others that do not.
    test::TemporaryFolder other;
    write_parts(mesh, other / "box.pvtu", parts.runner);
    std::uintmax_t most = 0;
    for (const auto& entry : fs::directory_iterator(other / "box")) most = std::max(most, entry.file_size());
    const test::FileSizeLimit limit(most - 1);
    const Diagnostic error = error_of([&] { write_parts(mesh, parts.folder / "box.pvtu", parts.runner); });
    CHECK(error.code == ErrorCode::OutputFailed);
    CHECK_THAT(error.message, Catch::Contains("box"));
  }
  SECTION("the disk is full from the start") {
    const test::FileSizeLimit limit(100);
    for (const char* name : {"box.pvtu", "new.pvtu", "new.msh"}) {
      CAPTURE(name);
      CHECK(error_of([&] { write_parts(mesh, parts.folder / name, parts.runner); }).code == ErrorCode::OutputFailed);
    }
  }
  SECTION("files of others in the folder") {
    std::ofstream(parts.folder / "box/notes.txt") << "mine";
    const auto write = [&] { write_parts(mesh, parts.folder / "box.pvtu", parts.runner); };
    CHECK(error_of(write).code == ErrorCode::OutputFailed);
    CHECK(fs::exists(parts.folder / "box/notes.txt"));
  }
  SECTION("the list is a folder") {
    fs::create_directory(parts.folder / "other.pvtu");
    CHECK(error_of([&] { write_parts(mesh, parts.folder / "other.pvtu", parts.runner); }).code ==
          ErrorCode::OutputFailed);
    fs::remove(parts.folder / "other.pvtu");
  }
  CHECK(parts.folder.file_count() == 2);
  CHECK(read_parts(parts.folder / "box.pvtu", *parts.communicator, parts.runner).part_count() == 4);
}

TEST_CASE("an output that is there is replaced, with pieces that are no more gone") {
  DamagedParts parts;
  const PartitionedMesh mesh = make_parts(make_case(false), 2, *parts.communicator, parts.runner);
  write_parts(mesh, parts.folder / "box.pvtu", parts.runner);
  CHECK(parts.folder.file_count() == 2);
  CHECK_FALSE(fs::exists(parts.piece(2)));
  CHECK(read_parts(parts.folder / "box.pvtu", *parts.communicator, parts.runner).part_count() == 2);
}
