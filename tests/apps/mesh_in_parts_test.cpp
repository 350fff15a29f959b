// Models that are meshed into parts, as a user does it.
#include <algorithm>
#include <cmath>
#include <csignal>
#include <sstream>

#include <catch2/catch.hpp>

#include "tests/apps/command_process.hpp"

using namespace tetloom::test;

namespace {

nlohmann::json mesh(const TestFolder& folder, const std::string& input, const std::string& output,
                    const std::vector<std::string>& more = {}) {
  std::vector<std::string> arguments{"mesh",
                                     input,
                                     "-o",
                                     folder / output,
                                     "--report",
                                     folder / "report.json",
                                     "--quiet",
                                     "--imprint",
                                     "--tets-per-part",
                                     "4000",
                                     "--relative-size",
                                     "0.03"};
  arguments.insert(arguments.end(), more.begin(), more.end());
  const ProcessResult result = run_tetloom(arguments);
  CAPTURE(result.err);
  REQUIRE(result.status == 0);
  return read_json(folder / "report.json");
}

nlohmann::json check(const std::string& file, const TestFolder& folder) {
  const ProcessResult result = run_tetloom({"check", file, "--report", folder / "check.json"});
  CAPTURE(result.err);
  CHECK(result.status == 0);
  return read_json(folder / "check.json");
}

/// Figures of parts are those of the mesh in one piece, up to the rounding of sums.
void check_figures(const nlohmann::json& found, const nlohmann::json& expected) {
  const nlohmann::json values = found.flatten(), expected_values = expected.flatten();
  REQUIRE(values.size() == expected_values.size());
  for (const auto& [path, value] : expected_values.items()) {
    CAPTURE(path);
    REQUIRE(values.contains(path));
    if (value.is_number_float()) {
      CHECK(values[path].get<double>() == Approx(value.get<double>()).epsilon(1e-12));
    } else {
      CHECK(values[path] == value);
    }
  }
}

}  // namespace

TEST_CASE("a model is meshed into parts, and they are the mesh in one piece") {
  const TestFolder folder;
  const std::string model = demo_model("assembly");
  const nlohmann::json whole = mesh(folder, model, "whole.vtu");
  REQUIRE(whole["filling"]["parts"]["parts"] >= 2);
  struct Case {
    std::string output;
    std::vector<std::string> more;
    int parts;
  };
  const std::vector<Case> cases{{"as_made.pvtu", {}, whole["filling"]["parts"]["parts"]},
                                {"three.pvtu", {"--parts", "3"}, 3},
                                {"one.msh", {"--parts", "1"}, 1},
                                {"three.msh", {"--parts", "3"}, 3}};
  for (const Case& one : cases) {
    CAPTURE(one.output);
    const nlohmann::json report = mesh(folder, model, one.output, one.more);
    CHECK(report["digest"] == whole["digest"]);
    CHECK(report["counts"] == whole["counts"]);
    check_figures(report["quality"], whole["quality"]);
    CHECK(report["parts"] == one.parts);
    CHECK(report["partition"]["table"].size() == static_cast<std::size_t>(one.parts));
    const nlohmann::json checked = check(folder / one.output, folder);
    CHECK(checked["digest"] == whole["digest"]);
    if (one.parts > 1) CHECK(checked["parts"] == one.parts);
  }
}

TEST_CASE("boundary layers go to parts, are the same there, and no stack is cut when they are dealt anew") {
  const TestFolder folder;
  const std::string model = demo_model("assembly");
  const std::vector<std::string> layers{"--layers", "*", "--first-height", "0.2", "--layer-count", "5"};
  const nlohmann::json whole = mesh(folder, model, "whole.vtu", layers);
  CHECK(whole["layers"]["cells"]["prisms"] == whole["counts"]["prisms"]);
  CHECK(whole["quality"]["cells"]["min_scaled_jacobian"] > 0);
  std::vector<std::string> in_three = layers;
  in_three.insert(in_three.end(), {"--parts", "3"});
  const nlohmann::json parts = mesh(folder, model, "three.pvtu", in_three);
  CHECK(parts["digest"] == whole["digest"]);
  CHECK(parts["counts"] == whole["counts"]);
  check_figures(parts["quality"], whole["quality"]);
  CHECK(parts["layers"]["by_face"] == whole["layers"]["by_face"]);
  CHECK(check(folder / "three.pvtu", folder)["digest"] == whole["digest"]);
  for (const std::string input : {"whole.vtu", "three.pvtu"}) {
    CAPTURE(input);
    REQUIRE(run_tetloom({"partition", folder / input, "--parts", "5", "-o", folder / "five.pvtu", "--report",
                         folder / "five.json", "--quiet"})
                .status == 0);
    const nlohmann::json five = read_json(folder / "five.json");
    CHECK(five["digest"] == whole["digest"]);
    CHECK(five["partition"]["imbalance"]["elements"] < 0.1);
    const nlohmann::json checked = check(folder / "five.pvtu", folder);
    CHECK(checked["digest"] == whole["digest"]);
    CHECK(checked["mesh"]["cell_fields"].size() == 3);
  }
}

TEST_CASE("the files of parts do not depend on threads") {
  const TestFolder folder;
  const std::string model = demo_model("assembly");
  const nlohmann::json report = mesh(folder, model, "a.pvtu", {"--threads", "1"});
  mesh(folder, model, "b.pvtu", {"--threads", "4"});
  for (int part = 0; part < report["parts"]; ++part) {
    const std::string number = std::to_string(part) + ".vtu";
    CHECK(read_text(folder / ("a/a_" + number)) == read_text(folder / ("b/b_" + number)));
  }
}

TEST_CASE("units and groups reach an OpenFOAM case in parts, and its names the report") {
  const TestFolder folder;
  const std::string model = demo_model("assembly");
  const std::vector<std::string> more{"--parts", "2", "--unit", "m", "--group", "held=faces:1,2"};
  const nlohmann::json report = mesh(folder, model, "a.foam", more);
  CHECK(report["unit"]["scale"].get<double>() == Approx(1e-3));
  CHECK(report["groups"]["held"]["ids"].size() == 2);
  CHECK_FALSE(report["names"].empty());
  double largest = 0;
  for (const std::string part : {"0", "1"}) {
    const std::string poly = "a.foam/processor" + part + "/constant/polyMesh/";
    CHECK(read_text(folder / (poly + "boundary")).find("held\n") != std::string::npos);
    std::istringstream points(read_text(folder / (poly + "points")));
    std::string line;
    while (std::getline(points, line) && line != "(") {}
    while (std::getline(points, line) && line != ")") largest = std::max(largest, std::abs(std::stod(line.substr(1))));
  }
  CHECK(largest < 1);  // metres of a part of some hundred millimetres
  CHECK(largest > 0);
}

TEST_CASE("a surface cannot be meshed into parts") {
  const TestFolder folder;
  const std::string open = folder.write("open.stl", cube_stl(10));
  CHECK(run_tetloom({"mesh", open, "-o", folder / "a.pvtu"}).status == 3);
  CHECK(run_tetloom({"mesh", open, "-o", folder / "a.msh", "--parts", "2"}).status == 3);
  CHECK(folder.files() == std::vector<std::string>{"open.stl"});
}

TEST_CASE("a cancelled run into parts leaves nothing behind") {
  for (const std::string stage : {"faces", "volume", "partition", "check"}) {
    CAPTURE(stage);
    ProcessOptions options;
    options.signal_when = stage;
    options.signals = {SIGINT};
    CHECK(in_time([&]() -> std::optional<bool> {
      const TestFolder folder;
      const ProcessResult result = run_tetloom({"mesh", demo_model("part"), "-o", folder / "a.pvtu", "--relative-size",
                                                "0.01", "--parts", "8", "--report", folder / "r.json"},
                                               options);
      if (result.status == 0) {
        CHECK(folder.files() == std::vector<std::string>{"a", "a.pvtu", "r.json"});
        return std::nullopt;
      }
      check_cancelled(result, folder, {"r.json"});
      return result.seconds_after_signal < kMostSecondsToCancel;
    }));
  }
}
