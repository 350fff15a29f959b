// The command's contract for everything that goes wrong: the right exit status, a message, a report, nothing half
// written.
#include <sys/resource.h>

#include <catch2/catch.hpp>
#include <filesystem>
#include <random>

#include "tests/apps/command_process.hpp"

using namespace tetloom::test;

namespace {

/// Runs `tetloom mesh INPUT -o out.vtu --report report.json` in `folder`, checks what every failure has in common, and
/// returns the message.
std::string check_failure(const TestFolder& folder, const std::string& input, int status, const std::string& code,
                          std::vector<std::string> more = {}, const ProcessOptions& options = {}) {
  const std::string output = folder / "out.vtu", report = folder / "report.json";
  std::vector<std::string> arguments{"mesh", input, "-o", output, "--report", report};
  arguments.insert(arguments.end(), more.begin(), more.end());
  const ProcessResult result = run_tetloom(arguments, options);
  CAPTURE(arguments, result.err, result.out);
  CHECK(result.status == status);
  CHECK_THAT(result.err, Catch::Contains("tetloom: "));
  CHECK(result.out.empty());
  for (const std::string& name : folder.files()) {
    CAPTURE(name);
    CHECK(name.find(".tmp") == std::string::npos);
    CHECK(name != "out.vtu");
  }
  REQUIRE(std::filesystem::exists(report));
  const nlohmann::json json = read_json(report);
  CHECK(json["schema"] == 1);
  CHECK(json["status"] == (status == 5 ? "cancelled" : "failed"));
  REQUIRE_FALSE(json["errors"].empty());
  CHECK(json["errors"][0]["code"] == code);
  CHECK_FALSE(json["errors"][0]["message"].get<std::string>().empty());
  return json["errors"][0]["message"];
}

std::string random_bytes(std::size_t size, unsigned seed) {
  std::mt19937 generator(seed);
  std::string text(size, '\0');
  for (char& c : text) c = static_cast<char>(generator());
  return text;
}

}  // namespace

TEST_CASE("an input that is not there is unreadable, and the message names it") {
  const TestFolder folder;
  CHECK_THAT(check_failure(folder, folder / "none.step", 3, "input_unreadable"), Catch::Contains("none.step"));
}

TEST_CASE("files that hold no model are unreadable in every format") {
  for (const char* extension : {".step", ".iges", ".brep", ".stl", ".obj"}) {
    CAPTURE(extension);
    const TestFolder folder;
    const std::string name = std::string("bad") + extension;
    check_failure(folder, folder.write(name, ""), 3, "input_unreadable");
    check_failure(folder, folder.write(name, random_bytes(5000, 7)), 3, "input_unreadable");
  }
}

TEST_CASE("a truncated STEP file is unreadable") {
  const TestFolder folder;
  const std::string whole = read_text(demo_model("assembly"));
  check_failure(folder, folder.write("cut.step", whole.substr(0, whole.size() / 2)), 3, "input_unreadable");
}

TEST_CASE("a folder is no input") {
  const TestFolder folder;
  std::filesystem::create_directory(folder / "dir.step");
  check_failure(folder, folder / "dir.step", 3, "input_unreadable");
}

TEST_CASE("a STEP file without a shape is unsuitable") {
  const TestFolder folder;
  const std::string text =
      "ISO-10303-21;\nHEADER;\nFILE_DESCRIPTION((''),'2;1');\nFILE_NAME('','',(''),(''),'','','');\n"
      "FILE_SCHEMA(('AUTOMOTIVE_DESIGN'));\nENDSEC;\nDATA;\n#1=CARTESIAN_POINT('',(0.,0.,0.));\nENDSEC;\n"
      "END-ISO-10303-21;\n";
  check_failure(folder, folder.write("empty.step", text), 3, "input_unsuitable");
}

TEST_CASE("an extension that is wrong is the input's fault") {
  const TestFolder folder;
  CHECK_THAT(check_failure(folder, folder.write("part.docx", "text"), 3, "input_unreadable"),
             Catch::Contains("part.docx"));
  CHECK_THAT(check_failure(folder, folder.write("part.brep", read_text(demo_model("assembly"))), 3, "input_unreadable"),
             Catch::Contains("part.brep"));
}

TEST_CASE("sizes of zero, below zero, or not a number are wrong usage, and still reported") {
  for (const char* size : {"0", "-1", "nan", "inf", "abc", ""}) {
    CAPTURE(size);
    const TestFolder folder;
    check_failure(folder, demo_model("assembly"), 2, "invalid_argument", {"--size", size});
  }
}

TEST_CASE("a size whose mesh cannot fit in memory is refused before the work") {
  const TestFolder folder;
  CHECK_THAT(check_failure(folder, demo_model("assembly"), 6, "out_of_memory", {"--size", "1e-6"}),
             Catch::Contains("memory") || Catch::Contains("GiB") || Catch::Contains("bytes"));
  check_failure(folder, demo_model("assembly"), 6, "out_of_memory", {"--size", "0.5", "--max-memory", "1M"});
}

TEST_CASE("a file of sizes that asks for what is not there is wrong usage") {
  const TestFolder folder;
  const std::string sizes = folder.write("sizes.json", R"({"entities": [{"name": "steel bodi", "size": 1}]})");
  CHECK_THAT(check_failure(folder, demo_model("assembly"), 2, "invalid_argument", {"--sizes", sizes}),
             Catch::Contains("steel bodi") && Catch::Contains("'steel body'"));
  folder.write("sizes.json", "{\n\"entities\": [}");
  CHECK_THAT(check_failure(folder, demo_model("assembly"), 2, "invalid_argument", {"--sizes", sizes}),
             Catch::Contains("line 2"));
  check_failure(folder, demo_model("assembly"), 2, "invalid_argument", {"--sizes", folder / "none.json"});
}

TEST_CASE("an open surface is no volume: it is meshed as a sheet, and said to be open") {
  const TestFolder folder;
  const std::string input = folder.write("open.stl", cube_stl(11));
  const ProcessResult result =
      run_tetloom({"mesh", input, "-o", folder / "out.vtu", "--report", folder / "report.json"});
  CAPTURE(result.err);
  CHECK(result.status == 0);
  const nlohmann::json report = read_json(folder / "report.json");
  CHECK(report["counts"]["tets"] == 0);
  CHECK(report["counts"]["triangles"] > 0);
  CHECK_FALSE(report["warnings"].empty());
}

TEST_CASE("a solid whose surface crosses itself names the faces and a point, or is made anew") {
  // A cube with a corner pulled through the opposite face.
  const TestFolder folder;
  std::string text = cube_stl();
  for (std::size_t at = 0; (at = text.find("vertex 1 1 1", at)) != std::string::npos; ++at) {
    text.replace(at, 12, "vertex -1 -2 -3");
  }
  const std::string input = folder.write("crossing.stl", text);
  check_failure(folder, input, 4, "self_intersection", {"--size", "0.3", "--no-heal"});
  const nlohmann::json error = read_json(folder / "report.json")["errors"][0];
  CHECK_FALSE(error["entities"].empty());
  CHECK(error["point"].is_array());

  const std::string report = folder / "healed.json";
  const ProcessResult healed =
      run_tetloom({"mesh", input, "-o", folder / "healed.vtu", "--size", "0.3", "--report", report});
  CAPTURE(healed.err);
  CHECK(healed.status == 0);
  CHECK(read_json(report)["rebuilt"] == nlohmann::json::parse("[[1]]"));
  CHECK(run_tetloom({"check", folder / "healed.vtu"}).status == 0);
}

TEST_CASE("an output that cannot be written is found before the work") {
  const TestFolder folder;
  const std::string report = folder / "report.json";
  for (const std::string& output : {folder / "no such folder/out.vtu", std::string("/proc/out.vtu")}) {
    const ProcessResult result =
        run_tetloom({"mesh", demo_model("assembly"), "-o", output, "--report", report, "--size", "4"});
    CAPTURE(output, result.err);
    CHECK(result.status == 6);
    const nlohmann::json json = read_json(report);
    CHECK(json["errors"][0]["code"] == "output_failed");
    CHECK(json["seconds"]["read"] == 0);
  }
  std::filesystem::create_directory(folder / "dir.vtu");
  CHECK(run_tetloom({"mesh", demo_model("assembly"), "-o", folder / "dir.vtu"}).status == 6);
}

TEST_CASE("an output of unknown format is wrong usage") {
  const TestFolder folder;
  const ProcessResult result = run_tetloom({"mesh", demo_model("assembly"), "-o", folder / "out.xyz"});
  CHECK(result.status == 2);
  CHECK_THAT(result.err, Catch::Contains("out.xyz") && Catch::Contains(".vtu"));
  CHECK(folder.files().empty());
}

TEST_CASE("a report that cannot be written is an error too") {
  const TestFolder folder;
  const ProcessResult result = run_tetloom(
      {"mesh", demo_model("assembly"), "-o", folder / "out.vtu", "--report", folder / "no such folder/r.json"});
  CHECK(result.status == 6);
  CHECK(folder.files().empty());
}

TEST_CASE("a full disk leaves nothing half written, and the old mesh as it was") {
  const TestFolder folder;
  ProcessOptions options;
  options.in_child = [] {
    const rlimit limit{64 * 1024, 64 * 1024};
    ::setrlimit(RLIMIT_FSIZE, &limit);
  };
  check_failure(folder, demo_model("assembly"), 6, "output_failed", {"--size", "4"}, options);
  const std::string old = folder.write("old.vtu", "an older mesh");
  const ProcessResult result = run_tetloom({"mesh", demo_model("assembly"), "-o", old, "--size", "4"}, options);
  CHECK(result.status == 6);
  CHECK(read_text(old) == "an older mesh");
}

TEST_CASE("a full disk leaves no piece of a mesh in parts, and the old parts as they were") {
  const TestFolder folder;
  ProcessOptions options;
  options.in_child = [] {
    const rlimit limit{64 * 1024, 64 * 1024};
    ::setrlimit(RLIMIT_FSIZE, &limit);
  };
  const std::vector<std::string> command{"mesh",  demo_model("assembly"), "-o", folder / "a.pvtu", "--parts", "3",
                                         "--size"};
  const auto run = [&](const std::string& size, const ProcessOptions& how) {
    std::vector<std::string> arguments = command;
    arguments.push_back(size);
    return run_tetloom(arguments, how);
  };
  const auto check_full = [&] {
    const ProcessResult result = run("4", options);
    CHECK(result.status == 6);
    CHECK_THAT(result.err, Catch::Contains("tetloom: ") && Catch::Contains("a_"));
  };
  check_full();
  CHECK(folder.files().empty());
  REQUIRE(run("8", {}).status == 0);
  const std::string list = read_text(folder / "a.pvtu"), piece = read_text(folder / "a/a_1.vtu");
  check_full();
  CHECK(folder.files() == std::vector<std::string>{"a", "a.pvtu"});
  CHECK(read_text(folder / "a.pvtu") == list);
  CHECK(read_text(folder / "a/a_1.vtu") == piece);
}

TEST_CASE("a worker that is killed, or is none, becomes an error") {
  const TestFolder folder;
  const std::string suicide = folder.write("suicide", "#!/bin/sh\nkill -9 $$\n");
  const std::string liar = folder.write("liar", "#!/bin/sh\necho nonsense\n");
  for (const std::string& path : {suicide, liar}) {
    std::filesystem::permissions(path, std::filesystem::perms::owner_all);
    check_failure(folder, demo_model("assembly"), 4, "worker_failed", {"--size", "4", "--tetgen", "--worker", path});
  }
  check_failure(folder, demo_model("assembly"), 4, "worker_failed", {"--size", "4", "--worker", folder / "none"});
}

TEST_CASE("memory that runs out, at whichever place, is an error and not a crash") {
  if (is_sanitized()) return;
  for (const rlim_t mebibytes : {200, 240, 280, 320, 360}) {
    CAPTURE(mebibytes);
    const TestFolder folder;
    ProcessOptions options;
    options.in_child = [mebibytes] {
      const rlimit limit{mebibytes << 20, mebibytes << 20};
      ::setrlimit(RLIMIT_AS, &limit);
    };
    check_failure(folder, demo_model("assembly"), 6, "out_of_memory", {"--size", "0.4", "--max-memory", "64G"},
                  options);
  }
}
