// The command that deals meshes to parts, and the others that read what it writes.
#include <signal.h>
#include <sys/resource.h>

#include <catch2/catch.hpp>
#include <filesystem>

#include "core/io/mesh_piece.hpp"
#include "core/mesh/mesh_access.hpp"
#include "tests/apps/command_process.hpp"
#include "tests/support/mixed_mesh.hpp"
#include "tetloom/check.hpp"
#include "tetloom/io.hpp"

using namespace tetloom::test;
using tetloom::Mesh;

namespace {

std::string write_box(const TestFolder& folder, bool mixed, int size = 4) {
  Mesh mesh = mixed ? make_mixed_box(size, size, size, 1, true) : make_tet_box(size, size, size, 1, true);
  mesh.cell_fields = {{"load", 1, std::vector<double>(tetloom::cell_count(mesh), 1)}, {"speed", 3, {}}};
  for (std::size_t i = 0; i < mesh.cell_fields[0].values.size() / 3; ++i) mesh.cell_fields[0].values[i] = 4;
  mesh.cell_fields[1].values.assign(3 * tetloom::cell_count(mesh), 0.5);
  tetloom::write_mesh(mesh, folder / "box.vtu");
  return folder / "box.vtu";
}

/// Runs `partition`, which must succeed, and returns its report.
nlohmann::json partition(const TestFolder& folder, const std::string& from, const std::string& to, int parts,
                         const std::vector<std::string>& more = {}) {
  std::vector<std::string> arguments{"partition", from,        "--parts",  std::to_string(parts),
                                     "-o",        folder / to, "--report", folder / "report.json"};
  arguments.insert(arguments.end(), more.begin(), more.end());
  const ProcessResult result = run_tetloom(arguments);
  CAPTURE(result.err);
  REQUIRE(result.status == 0);
  return read_json(folder / "report.json");
}

std::string digest_of(const std::string& file, const TestFolder& folder) {
  const ProcessResult check = run_tetloom({"check", file, "--report", folder / "check.json"});
  CAPTURE(check.err);
  CHECK(check.status == 0);
  return read_json(folder / "check.json")["digest"];
}

}  // namespace

TEST_CASE("a mesh goes through any number of parts and stays what it was") {
  const bool mixed = GENERATE(false, true);
  const std::string extension = GENERATE(".pvtu", ".msh");
  const TestFolder folder;
  std::string last = write_box(folder, mixed);
  const std::string digest = digest_of(last, folder);
  for (const int parts : {1, 5, 3, 64}) {
    CAPTURE(parts);
    const std::string name = "parts" + std::to_string(parts) + extension;
    const nlohmann::json report = partition(folder, last, name, parts);
    last = folder / name;
    CHECK(report["status"] == "ok");
    CHECK(report["digest"] == digest);
    CHECK(report["parts"] == parts);
    CHECK(report["partition"]["table"].size() == static_cast<std::size_t>(parts));
    CHECK((report["partition"]["cut_faces"] > 0) == (parts > 1));
    CHECK(digest_of(last, folder) == digest);
    CHECK(read_json(folder / "check.json")["parts"] == parts);
  }
}

TEST_CASE("the parts do not depend on threads") {
  const TestFolder folder;
  const std::string box = write_box(folder, true);
  partition(folder, box, "a.pvtu", 6, {"--threads", "1"});
  partition(folder, box, "b.pvtu", 6, {"--threads", "3"});
  for (int part = 0; part < 6; ++part) {
    const std::string number = std::to_string(part) + ".vtu";
    CHECK(read_text(folder / ("a/a_" + number)) == read_text(folder / ("b/b_" + number)));
  }
}

TEST_CASE("all methods partition, and partition again") {
  const TestFolder folder;
  const std::string box = write_box(folder, false);
  for (const char* method : {"multilevel", "rcb", "sfc", "scotch"}) {
    CAPTURE(method);
    const auto first = partition(folder, box, "a.pvtu", 5, {"--method", method});
    CHECK(first["partition"]["imbalance"]["elements"] < 0.2);
    const auto second = partition(folder, folder / "a.pvtu", "b.pvtu", 7, {"--method", method});
    CHECK(second["partition"]["imbalance"]["elements"] < 0.2);
    CHECK(first["digest"] == second["digest"]);
  }
}

TEST_CASE("weights are balanced instead of elements") {
  const TestFolder folder;
  const std::string box = write_box(folder, false);
  const auto report = partition(folder, box, "a.pvtu", 4, {"--weights", "load"});
  CHECK(report["partition"]["imbalance"]["weights"] < 0.1);
  CHECK(report["partition"]["imbalance"]["elements"] > 0.1);
  const ProcessResult result =
      run_tetloom({"partition", box, "--parts", "4", "-o", folder / "b.pvtu", "--weights", "load"});
  CHECK_THAT(result.out, Catch::Contains("weight") && Catch::Contains("imbalance") && Catch::Contains("neighbours"));
}

TEST_CASE("info tells of the parts, and many are summed up") {
  const TestFolder folder;
  partition(folder, write_box(folder, false), "a.pvtu", 40);
  const ProcessResult info = run_tetloom({"info", folder / "a.pvtu"});
  CHECK(info.status == 0);
  CHECK_THAT(info.out, Catch::Contains("least") && Catch::Contains("mean") && Catch::Contains("faces between"));
}

TEST_CASE("command lines that cannot be carried out are refused") {
  const TestFolder folder;
  const std::string box = write_box(folder, false), out = folder / "a.pvtu";
  CHECK(run_tetloom({"partition", box, "-o", out}).status == 2);
  CHECK(run_tetloom({"partition", box, "--parts", "0", "-o", out}).status == 2);
  CHECK(run_tetloom({"partition", box, "--parts", "-3", "-o", out}).status == 2);
  CHECK(run_tetloom({"partition", box, "--parts", "2", "-o", folder / "a.vtu"}).status == 2);
  CHECK(run_tetloom({"partition", box, "--parts", "2", "-o", out, "--method", "magic"}).status == 2);
  CHECK(run_tetloom({"partition", box, "--parts", "2", "-o", out, "--weights", "none"}).status == 2);
  CHECK(run_tetloom({"partition", box, "--parts", "2", "-o", out, "--weights", "speed"}).status == 2);
  CHECK(run_tetloom({"partition", folder / "none.vtu", "--parts", "2", "-o", out}).status == 3);
  CHECK(run_tetloom({"partition", folder / "none.pvtu", "--parts", "2", "-o", out}).status == 3);
  CHECK(run_tetloom({"partition", box, "--parts", "2", "-o", folder / "nowhere/a.pvtu"}).status == 6);
  CHECK(folder.files() == std::vector<std::string>{"box.vtu"});
}

TEST_CASE("pieces must not replace their own input") {
  const TestFolder folder;
  partition(folder, write_box(folder, false), "a.pvtu", 2);
  CHECK(run_tetloom({"partition", folder / "a.pvtu", "--parts", "3", "-o", folder / "a.pvtu"}).status == 2);
  CHECK(run_tetloom({"partition", folder / "a/a_0.vtu", "--parts", "3", "-o", folder / "a.pvtu"}).status == 2);
}

TEST_CASE("partitioned files that do not fit together are no input") {
  const TestFolder folder;
  partition(folder, write_box(folder, false), "a.pvtu", 3);
  const std::string piece = folder / "a/a_1.vtu";
  SECTION("a piece is missing") { std::filesystem::remove(piece); }
  SECTION("a piece is cut off") { std::filesystem::resize_file(piece, 5000); }
  for (const char* command : {"check", "info"}) {
    const ProcessResult result = run_tetloom({command, folder / "a.pvtu", "--report", folder / "r.json"});
    CHECK(result.status == 3);
    CHECK_THAT(result.err, Catch::Contains("a_"));
    CHECK(read_json(folder / "r.json")["status"] == "failed");
  }
}

TEST_CASE("pieces that are sound but do not fit each other are no valid mesh") {
  const TestFolder folder;
  partition(folder, write_box(folder, false), "a.pvtu", 3);
  const std::string list = folder / "a.pvtu", piece = folder / "a/a_1.vtu";
  tetloom::MeshPiece moved = tetloom::read_mesh_piece(piece);
  for (tetloom::Vec3& p : moved.mesh.points) p.z += 0.25;
  tetloom::write_mesh_piece(moved.mesh, moved.global_ids, piece);

  const ProcessResult check = run_tetloom({"check", list, "--report", folder / "r.json"});
  CHECK(check.status == 4);
  CHECK_THAT(check.out, Catch::Contains("NOT valid"));
  CHECK_THAT(check.err, Catch::Contains("a_"));
  const nlohmann::json report = read_json(folder / "r.json");
  CHECK(report["status"] == "failed");
  CHECK(report["errors"][0]["point"].is_array());
  CHECK(report["validation"]["valid"] == false);
  CHECK(report["validation"]["problems"][0]["kind"] == "unfit_pieces");
  CHECK(report["partition"]["table"].size() == 3);
  // For all others they are no input.
  CHECK(run_tetloom({"info", list}).status == 3);
  CHECK(run_tetloom({"partition", list, "--parts", "2", "-o", folder / "b.pvtu"}).status == 3);
}

TEST_CASE("an output that cannot be written is found before the work") {
  const TestFolder folder;
  const std::string box = write_box(folder, false), report = folder / "r.json";
  std::filesystem::create_directory(folder / "taken.pvtu");
  const auto before = folder.files();
  for (const std::string& output : {folder / "nowhere/a.pvtu", folder / "nowhere/a.msh", std::string("/proc/a.pvtu"),
                                    std::string("/proc/a.msh"), folder / "taken.pvtu"}) {
    CAPTURE(output);
    const ProcessResult result = run_tetloom({"partition", box, "--parts", "2", "-o", output, "--report", report});
    CHECK(result.status == 6);
    const nlohmann::json json = read_json(report);
    CHECK(json["status"] == "failed");
    CHECK(json["errors"][0]["code"] == "output_failed");
    CHECK(json["seconds"]["read"] == 0);
    std::filesystem::remove(report);
    CHECK(folder.files() == before);
  }
}

TEST_CASE("pieces do not replace what is no folder of pieces") {
  const TestFolder folder;
  const std::string box = write_box(folder, false);
  SECTION("a file of their folder's name") { folder.write("a", "a file"); }
  SECTION("a folder with other files") {
    std::filesystem::create_directory(folder / "a");
    folder.write("a/notes.txt", "mine");
  }
  const auto before = folder.files();
  CHECK(run_tetloom({"partition", box, "--parts", "2", "-o", folder / "a.pvtu"}).status == 6);
  CHECK(folder.files() == before);
}

TEST_CASE("a full disk leaves the old parts as they were") {
  const TestFolder folder;
  const std::string box = write_box(folder, false, 8);
  const auto old = partition(folder, box, "a.pvtu", 2);
  ProcessOptions options;
  options.in_child = [] {
    const rlimit limit{16 * 1024, 16 * 1024};
    ::setrlimit(RLIMIT_FSIZE, &limit);
  };
  const auto before = folder.files();
  for (const char* name : {"a.pvtu", "a.msh"})
    CHECK(run_tetloom({"partition", box, "--parts", "3", "-o", folder / name}, options).status == 6);
  CHECK(folder.files() == before);
  CHECK(digest_of(folder / "a.pvtu", folder) == old["digest"]);
}

TEST_CASE("a run that is killed or cancelled leaves parts that are whole") {
  const TestFolder folder;
  const std::string box = write_box(folder, false, 40);
  const std::string digest = partition(folder, box, "a.pvtu", 2)["digest"];
  const auto parts_that_stand = [&] {
    CHECK(digest_of(folder / "a.pvtu", folder) == digest);
    return read_json(folder / "check.json")["parts"];
  };
  REQUIRE(parts_that_stand() == 2);
  for (const std::string stage : {"read", "partition", "write"}) {
    for (const int signal : {SIGINT, SIGKILL}) {
      CAPTURE(stage, signal);
      const auto before = folder.files();
      ProcessOptions options;
      options.signal_when = stage;
      options.signals = {signal};
      const auto run_and_signal = [&]() -> std::optional<bool> {
        const ProcessResult result = run_tetloom({"partition", box, "--parts", "64", "-o", folder / "a.pvtu"}, options);
        const bool finished = result.status == 0;
        const nlohmann::json parts = parts_that_stand();
        if (signal == SIGINT) {
          CHECK((finished || result.status == 5));
          CHECK(parts == (finished ? 64 : 2));
          CHECK(folder.files() == before);
        } else {
          CHECK((finished || result.status == 128 + SIGKILL));
          CHECK((parts == 64 || (parts == 2 && !finished)));
        }
        if (parts != 2) partition(folder, box, "a.pvtu", 2);
        if (parts != 2 && stage != "write") return std::nullopt;
        return signal == SIGKILL || result.seconds_after_signal < kMostSecondsToCancel;
      };
      // In the last stage the end may well come first; the new parts stand there then.
      CHECK(in_time(run_and_signal));
    }
  }
}

TEST_CASE("a cancelled run leaves nothing behind") {
  ProcessOptions options;
  options.signal_when = "read";
  options.signals = {SIGINT};
  CHECK(in_time([&]() -> std::optional<bool> {
    const TestFolder folder;
    const std::string box = write_box(folder, false, 40);
    const ProcessResult result = run_tetloom(
        {"partition", box, "--parts", "64", "-o", folder / "a.pvtu", "--report", folder / "r.json"}, options);
    if (result.status == 0) return std::nullopt;
    check_cancelled(result, folder, {"box.vtu", "r.json"});
    return result.seconds_after_signal < kMostSecondsToCancel;
  }));
}
