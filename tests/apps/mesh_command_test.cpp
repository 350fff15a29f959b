// The commands as a user runs them.
#include <csignal>

#include <algorithm>
#include <catch2/catch.hpp>
#include <filesystem>
#include <regex>

#include "core/mesh/mesh_access.hpp"
#include "tests/apps/command_process.hpp"
#include "tests/support/mixed_mesh.hpp"
#include "tetloom/io.hpp"

using namespace tetloom::test;

namespace {

nlohmann::json mesh_with_report(const TestFolder& folder, const std::string& input, const std::string& output,
                                std::vector<std::string> more = {}) {
  std::vector<std::string> arguments{"mesh", input, "-o", folder / output, "--report", folder / "report.json"};
  arguments.insert(arguments.end(), more.begin(), more.end());
  const ProcessResult result = run_tetloom(arguments);
  INFO(result.err);
  REQUIRE(result.status == 0);
  return read_json(folder / "report.json");
}

}  // namespace

TEST_CASE("a CAD model becomes a valid mesh, with a summary and a report") {
  const TestFolder folder;
  const ProcessResult result = run_tetloom({"mesh", demo_model("part"), "-o", folder / "part.vtu", "--relative-size",
                                            "0.04", "--report", folder / "report.json", "--threads", "2"});
  CAPTURE(result.err);
  REQUIRE(result.status == 0);
  CHECK_THAT(result.out, Catch::Contains("tets in 1 region") && Catch::Contains("mean ratio") &&
                             Catch::Contains("within [0.71, 1.41]") && Catch::Contains("part.vtu"));
  CHECK(result.out.find('\033') == std::string::npos);
  const nlohmann::json report = read_json(folder / "report.json");
  CHECK(report["schema"] == 1);
  CHECK(report["status"] == "ok");
  CHECK(report["threads"] == 2);
  CHECK(report["counts"]["tets"] > 1000);
  CHECK(report["counts"]["regions"] == 1);
  CHECK(report["volume"]["mesh"].get<double>() == Approx(report["volume"]["model"].get<double>()).epsilon(0.01));
  CHECK(report["quality"]["mean_ratio_mean"] > 0.7);
  CHECK(report["quality"]["min_dihedral_deg"] > 0);
  CHECK(report["quality"]["edges_in_band"] > 0.5);
  CHECK(report["digest"].get<std::string>().size() == 32);
  CHECK(report["errors"].empty());
  CHECK(report["seconds"]["total"] > 0);
  CHECK(report["peak_bytes"] > 1 << 20);
  CHECK(run_tetloom({"check", folder / "part.vtu"}).status == 0);
}

TEST_CASE("--unit scales what is written, and the report says by how much") {
  const TestFolder folder;
  const std::string input = demo_model("part");
  const auto given = mesh_with_report(folder, input, "given.vtu", {"--relative-size", "0.1"});
  CHECK_FALSE(given.contains("unit"));
  const auto metres = mesh_with_report(folder, input, "metres.vtu", {"--relative-size", "0.1", "--unit", "m"});
  CHECK(metres["unit"]["scale"].get<double>() == Approx(1e-3));
  CHECK(metres["volume"] == given["volume"]);
  const tetloom::Mesh a = tetloom::read_mesh(folder / "given.vtu"), b = tetloom::read_mesh(folder / "metres.vtu");
  REQUIRE(a.points.size() == b.points.size());
  for (std::size_t v = 0; v < a.points.size(); ++v)
    CHECK(tetloom::distance(1e-3 * a.points[v], b.points[v]) <= 1e-15 * tetloom::norm(a.points[v]));

  tetloom::write_mesh(a, folder / "facets.stl");  // says no unit
  const ProcessResult refused = run_tetloom({"mesh", folder / "facets.stl", "-o", folder / "c.vtu", "--unit", "mm"});
  CHECK(refused.status == 2);
  CHECK_THAT(refused.err, Catch::Contains("--unit") && Catch::Contains("unit of its lengths"));
  CHECK_FALSE(std::filesystem::exists(folder / "c.vtu"));
}

TEST_CASE("files for solvers are written by their extension") {
  const TestFolder folder;
  const std::string input = demo_model("assembly");
  for (const char* output : {"a.inp", "a.su2", "a.bdf", "a.foam", "a.foam"})  // the second time it is there
    mesh_with_report(folder, input, output, {"--relative-size", "0.1"});
  CHECK(std::filesystem::exists(std::filesystem::path(folder / "a.foam") / "constant" / "polyMesh" / "owner"));
  mesh_with_report(folder, input, "a.msh", {"--relative-size", "0.1", "--msh-version", "2.2", "--ascii"});
  CHECK(read_text(folder / "a.msh").starts_with("$MeshFormat\n2.2 0 8\n"));
}

TEST_CASE("second order is reported, checked and read back") {
  const TestFolder folder;
  const std::string input = demo_model("sphere");
  const auto report = mesh_with_report(folder, input, "a.vtu", {"--size", "20", "--order", "2"});
  const auto& second_order = report["second_order"];
  CHECK(second_order["mid_nodes"].get<int>() > 100);
  CHECK(second_order["curved"].get<int>() > 100);
  CHECK(second_order["invalid"] == 0);
  CHECK(second_order["off_model"].empty());
  CHECK(report["quality"]["second_order"]["min_scaled_jacobian"].get<double>() > 0.1);
  CHECK(report["seconds"]["second_order"].get<double>() >= 0);
  const ProcessResult check = run_tetloom({"check", folder / "a.vtu", "--report", folder / "check.json"});
  CHECK(check.status == 0);
  CHECK_THAT(check.out, Catch::Contains("curved"));
  CHECK(read_json(folder / "check.json")["digest"] == report["digest"]);

  // Adaptation and parts are of first order.
  const ProcessResult parts = run_tetloom({"partition", folder / "a.vtu", "--parts", "2", "-o", folder / "p.pvtu"});
  CHECK(parts.status == 0);
  for (const auto& arguments :
       std::vector<std::vector<std::string>>{{"--order", "2", "-o", folder / "a.su2"},
                                             {"--order", "3", "-o", folder / "a.vtu"},
                                             {"--order", "2", "-o", folder / "a.pvtu"},
                                             {"--order", "2", "-o", folder / "a.vtu", "--layers", "*", "--first-height",
                                              "0.01", "--layer-count", "3", "--all-tets"},
                                             {"--min-scaled-jacobian", "0.2", "-o", folder / "a.vtu"},
                                             {"--order", "2", "--min-scaled-jacobian", "1", "-o", folder / "a.vtu"}}) {
    std::vector<std::string> words{"mesh", input};
    words.insert(words.end(), arguments.begin(), arguments.end());
    CHECK(run_tetloom(words).status == 2);
  }
}

TEST_CASE("boundary layers of second order are written, checked and read back") {
  const TestFolder folder;
  const auto report = mesh_with_report(folder, demo_model("sphere"), "a.vtu",
                                       {"--size", "20", "--order", "2", "--layers", "*", "--first-height", "0.2",
                                        "--growth", "1.2", "--layer-count", "5"});
  CHECK(report["layers"]["cells"]["prisms"].get<int>() > 500);
  CHECK(report["second_order"]["invalid"] == 0);
  CHECK(report["second_order"]["off_model"].empty());
  CHECK(report["quality"]["second_order"]["curved_cells"].get<int>() > 500);
  CHECK(report["warnings"].empty());
  const ProcessResult check = run_tetloom({"check", folder / "a.vtu", "--report", folder / "check.json"});
  CHECK(check.status == 0);
  CHECK(read_json(folder / "check.json")["digest"] == report["digest"]);
}

TEST_CASE("groups of faces get to files for solvers and into the report") {
  const TestFolder folder;
  const std::string input = demo_model("part");
  const auto report =
      mesh_with_report(folder, input, "a.inp",
                       {"--relative-size", "0.1", "--group", "support=faces:bolt*", "--group", "top=faces:spline top"});
  CHECK(report["groups"]["support"]["ids"].size() == 4);
  CHECK_THAT(read_text(folder / "a.inp"), Catch::Contains("*SURFACE, NAME=support,") && Catch::Contains("NSET=top\n"));
  const ProcessResult refused = run_tetloom({"mesh", input, "-o", folder / "b.inp", "--group", "load=faces:nothing"});
  CHECK(refused.status == 2);
  CHECK_THAT(refused.err, Catch::Contains("'nothing'"));
}

TEST_CASE("the mesh does not depend on the number of threads") {
  const TestFolder folder;
  const std::string input = demo_model("assembly");
  const auto one = mesh_with_report(folder, input, "1.vtu", {"--imprint", "--threads", "1", "--relative-size", "0.05"});
  const auto three =
      mesh_with_report(folder, input, "3.vtu", {"--imprint", "--threads", "3", "--relative-size", "0.05"});
  CHECK(one["digest"] == three["digest"]);
  CHECK(one["quality"] == three["quality"]);
  CHECK(one["seconds"]["check"] > 0);
  CHECK(read_text(folder / "1.vtu") == read_text(folder / "3.vtu"));
}

TEST_CASE("what check and info find does not depend on the number of threads") {
  const TestFolder folder;
  tetloom::write_mesh(make_mixed_box(20, 20, 20, 3, true), folder / "box.vtu");
  for (const char* command : {"check", "info"}) {
    std::vector<nlohmann::json> reports;
    for (const char* threads : {"1", "2", "5"}) {
      const ProcessResult result =
          run_tetloom({command, folder / "box.vtu", "--threads", threads, "--report", folder / "report.json"});
      INFO(result.err);
      REQUIRE(result.status == 0);
      reports.push_back(read_json(folder / "report.json"));
      CHECK(std::to_string(reports.back()["threads"].get<int>()) == threads);
      for (const char* varying : {"threads", "seconds", "peak_bytes"}) reports.back().erase(varying);
    }
    CHECK(reports[1] == reports[0]);
    CHECK(reports[2] == reports[0]);
  }
}

TEST_CASE("goals for the tets are aimed at and reported") {
  const TestFolder folder;
  const std::string input = demo_model("part");
  const auto usual = mesh_with_report(folder, input, "a.vtu", {"--relative-size", "0.04"})["filling"];
  CHECK(usual["goals"]["min_dihedral_deg"] == 15);
  const auto higher =
      mesh_with_report(folder, input, "b.vtu", {"--relative-size", "0.04", "--min-dihedral", "25"})["filling"];
  CHECK(higher["goals"]["min_dihedral_deg"] == 25);
  const auto hasty = mesh_with_report(folder, input, "c.vtu",
                                      {"--relative-size", "0.04", "--min-dihedral", "25", "--rounds", "0"})["filling"];
  CHECK(hasty["optimizer"]["points_inserted"] == 0);
  CHECK(higher["optimizer"]["below_dihedral"] < hasty["optimizer"]["below_dihedral"]);
}

TEST_CASE("small angles are told with the faces and the edge that force them") {
  const TestFolder folder;
  // A wedge of 5 degrees at the z axis: the prism over the triangle (0, 0), (1, 0), (cos 5, sin 5).
  const std::array<std::string, 6> corners{"0 0 0", "1 0 0", "0.99619469809 0.08715574275 0",
                                           "0 0 1", "1 0 1", "0.99619469809 0.08715574275 1"};
  std::string stl = "solid wedge\n";
  for (const auto& [a, b, c] :
       {std::array{0, 2, 1}, {3, 4, 5}, {0, 1, 4}, {0, 4, 3}, {1, 2, 5}, {1, 5, 4}, {2, 0, 3}, {2, 3, 5}})
    stl += "facet normal 0 0 0\nouter loop\nvertex " + corners[a] + "\nvertex " + corners[b] + "\nvertex " +
           corners[c] + "\nendloop\nendfacet\n";
  const std::string input = folder.write("wedge.stl", stl + "endsolid wedge\n");
  const ProcessResult result =
      run_tetloom({"mesh", input, "-o", folder / "w.vtu", "--size", "0.1", "--report", folder / "report.json"});
  CAPTURE(result.out, result.err);
  REQUIRE(result.status == 0);
  const auto acute = read_json(folder / "report.json")["filling"]["acute_tets"];
  CHECK(acute["count"] > 0);
  CHECK(acute["count"] == acute["not_forced"].get<int>() + acute["forced_by_angles"].get<int>() +
                              acute["forced_by_triangles"].get<int>() + acute["forced_by_points"].get<int>());
  REQUIRE(acute["worst"].size() > 0);
  std::size_t by_edge = 0;
  for (const auto& tet : acute["worst"]) {
    if (tet["cause"] != "surface_angle") continue;
    CHECK(tet["cause_deg"].get<double>() == Approx(5));
    REQUIRE(tet["entities"].size() == 3);
    CHECK(tet["entities"][0]["dim"] == 2);
    CHECK(tet["entities"][1]["dim"] == 2);
    CHECK(tet["entities"][2]["dim"] == 1);
    ++by_edge;
  }
  CHECK(by_edge >= 5);
  CHECK_THAT(result.out, Catch::Contains("below 15°, the surface forces") && Catch::Contains("the worst on "));
}

TEST_CASE("every format holds the same mesh") {
  const TestFolder folder;
  const std::string input = demo_model("assembly");
  for (const char* name : {"a.vtu", "a.msh", "a.mesh", "a.meshb"}) {
    CAPTURE(name);
    const auto written = mesh_with_report(folder, input, name, {"--imprint", "--relative-size", "0.06"});
    const ProcessResult check = run_tetloom({"check", folder / name, "--report", folder / "check.json"});
    CAPTURE(check.err);
    CHECK(check.status == 0);
    const auto checked = read_json(folder / "check.json");
    CHECK(checked["validation"]["valid"] == true);
    CHECK(checked["counts"] == written["counts"]);
    CHECK(checked["volume"]["mesh"] == written["volume"]["mesh"]);
  }
}

TEST_CASE("touching solids share faces once they are imprinted") {
  const TestFolder folder;
  const auto apart = mesh_with_report(folder, demo_model("assembly"), "a.vtu", {"--relative-size", "0.06"});
  const auto together =
      mesh_with_report(folder, demo_model("assembly"), "b.vtu", {"--relative-size", "0.06", "--imprint"});
  CHECK(apart["counts"]["regions"] == 2);
  CHECK(together["counts"]["regions"] == 2);
  run_tetloom({"check", folder / "a.vtu", "--report", folder / "check_a.json"});
  run_tetloom({"check", folder / "b.vtu", "--report", folder / "check_b.json"});
  CHECK(read_json(folder / "check_a.json")["validation"]["interface_faces"] == 0);
  CHECK(read_json(folder / "check_b.json")["validation"]["interface_faces"] > 100);
}

TEST_CASE("the space around solids that touch has their common skin") {
  const TestFolder folder;
  const std::string output = folder / "around.vtu";
  const auto around =
      mesh_with_report(folder, demo_model("assembly"), "around.vtu", {"--relative-size", "0.06", "--far-field", "3"});
  CHECK(around["counts"]["regions"] == 1);
  CHECK(around["volume"]["mesh"].get<double>() == Approx(around["volume"]["model"].get<double>()).epsilon(1e-2));
  CHECK(run_tetloom({"check", output}).status == 0);
}

TEST_CASE("only the surface is meshed when that is asked for, or when the output is STL") {
  const TestFolder folder;
  for (const auto& [name, option] : {std::pair{"s.vtu", true}, {"s.stl", false}}) {
    const auto report =
        mesh_with_report(folder, demo_model("part"), name,
                         option ? std::vector<std::string>{"--surface-only"} : std::vector<std::string>{});
    CHECK(report["counts"]["tets"] == 0);
    CHECK(report["counts"]["triangles"] > 100);
    CHECK(report["quality"]["mean_ratio_mean"].is_null());
    CHECK(report["quality"]["edges_in_band"] > 0.5);
    CHECK(report["volume"]["model"].is_null());
  }
}

TEST_CASE("sizes by name make a mesh finer there") {
  const TestFolder folder;
  const std::string sizes = folder.write("sizes.json", R"({"entities": [{"name": "bore", "size": 1.5}]})");
  const auto coarse = mesh_with_report(folder, demo_model("part"), "a.vtu", {"--size", "6", "--surface-only"});
  const auto fine =
      mesh_with_report(folder, demo_model("part"), "b.vtu", {"--size", "6", "--surface-only", "--sizes", sizes});
  CHECK(fine["counts"]["triangles"] > 1.5 * coarse["counts"]["triangles"].get<double>());
}

TEST_CASE("info describes a model: unit, counts, names, colours") {
  const TestFolder folder;
  const ProcessResult result = run_tetloom({"info", demo_model("assembly"), "--report", folder / "info.json"});
  CHECK(result.status == 0);
  CHECK_THAT(result.out, Catch::Contains("STEP") && Catch::Contains("1 mm") && Catch::Contains("2 regions") &&
                             Catch::Contains("steel body") && Catch::Contains("rubber seal") && Catch::Contains("#"));
  const auto model = read_json(folder / "info.json")["model"];
  CHECK(model["counts"]["regions"] == 2);
  CHECK(model["regions"][0]["name"] == "steel body");
  CHECK(model["regions"][0]["volume"] > 0);
  CHECK(model["faces"].size() == model["counts"]["faces"]);
  CHECK_THAT(run_tetloom({"info", demo_model("part")}).out, Catch::Contains("spline top"));
}

TEST_CASE("info describes a mesh") {
  const TestFolder folder;
  mesh_with_report(folder, demo_model("assembly"), "a.vtu", {"--imprint", "--relative-size", "0.06"});
  const ProcessResult result = run_tetloom({"info", folder / "a.vtu"});
  CHECK(result.status == 0);
  CHECK_THAT(result.out, Catch::Contains("tets") && Catch::Contains("steel body") && Catch::Contains("rubber seal"));
  CHECK(run_tetloom({"info", folder / "none.vtu"}).status == 3);
}

TEST_CASE("check trusts nobody: an inverted tet is found whoever wrote it") {
  const TestFolder folder;
  const std::string head = "MeshVersionFormatted 2\nDimension 3\nVertices\n4\n0 0 0 0\n1 0 0 0\n0 1 0 0\n0 0 1 0\n";
  const std::string good = folder.write("good.mesh", head + "Tetrahedra\n1\n1 2 3 4 1\nEnd\n");
  const std::string bad = folder.write("bad.mesh", head + "Tetrahedra\n1\n1 3 2 4 1\nEnd\n");
  CHECK(run_tetloom({"check", good}).status == 0);
  const ProcessResult result = run_tetloom({"check", bad, "--report", folder / "check.json"});
  CHECK(result.status == 4);
  CHECK_THAT(result.out, Catch::Contains("NOT valid"));
  CHECK_FALSE(result.err.empty());
  const auto report = read_json(folder / "check.json");
  CHECK(report["validation"]["valid"] == false);
  CHECK(report["validation"]["problems"][0]["kind"] == "non_positive_volume");
}

TEST_CASE("check of what is no mesh is bad input") {
  const TestFolder folder;
  CHECK(run_tetloom({"check", folder / "none.vtu"}).status == 3);
  CHECK(run_tetloom({"check", folder.write("junk.vtu", "junk")}).status == 3);
  CHECK(run_tetloom({"check", folder.write("part.docx", "junk")}).status == 3);
  CHECK(run_tetloom({"check", folder.write("cut.mesh", "MeshVersionFormatted 2\nDimension 3\nVertices\n100\n0 0")})
            .status == 3);
}

TEST_CASE("quiet runs print nothing, and errors all the same") {
  const TestFolder folder;
  const ProcessResult good =
      run_tetloom({"mesh", demo_model("assembly"), "-o", folder / "a.vtu", "--size", "6", "--quiet"});
  CHECK(good.status == 0);
  CHECK(good.out.empty());
  CHECK(good.err.empty());
  const ProcessResult bad = run_tetloom({"mesh", folder / "none.step", "-o", folder / "b.vtu", "--quiet"});
  CHECK(bad.status == 3);
  CHECK_THAT(bad.err, Catch::Contains("none.step"));
}

TEST_CASE("a reader that goes away does not end the work") {
  const TestFolder folder;
  ProcessOptions options;
  options.close_stdout = true;
  CHECK(run_tetloom({"mesh", demo_model("assembly"), "-o", folder / "a.vtu", "--size", "6"}, options).status == 0);
  CHECK(folder.files() == std::vector<std::string>{"a.vtu"});
}

TEST_CASE("a volume that is not the model's is told in the text and in the report") {
  const TestFolder folder;
  const ProcessResult result =
      run_tetloom({"mesh", demo_model("plate"), "-o", folder / "a.vtu", "--size", "20", "--report", folder / "r.json"});
  CHECK(result.status == 0);
  CHECK_THAT(result.err, Catch::Contains("where the model has"));
  const nlohmann::json warnings = read_json(folder / "r.json")["warnings"];
  const auto differs = [](const nlohmann::json& warning) { return warning["code"] == "volume_differs"; };
  const auto found = std::find_if(warnings.begin(), warnings.end(), differs);
  REQUIRE(found != warnings.end());
  CHECK((*found)["entities"][0]["dim"] == 3);
  CHECK((*found)["entities"][1]["dim"] == 2);
  CHECK((*found)["point"].size() == 3);
}

TEST_CASE("Ctrl-C ends a run within a second, wherever it is, and leaves a report and nothing else") {
  for (const char* stage : {"read", "faces", "volume"}) {
    CAPTURE(stage);
    ProcessOptions options;
    options.signal_when = stage;
    options.signals = {SIGINT};
    const bool volume = std::string(stage) == "volume";
    CHECK(in_time([&]() -> std::optional<bool> {
      const TestFolder folder;
      const std::string sleeper = folder.write("sleeper", "#!/bin/sh\nexec sleep 60\n");
      std::filesystem::permissions(sleeper, std::filesystem::perms::owner_all);
      const std::vector<std::string> arguments{"mesh",         demo_model("spline"),
                                               "-o",           folder / "out.vtu",
                                               "--report",     folder / "r.json",
                                               "--size",       volume ? "8" : "0.4",
                                               "--worker",     sleeper,
                                               "--max-memory", "64G"};
      const ProcessResult result = run_tetloom(arguments, options);
      if (result.status == 0) return std::nullopt;
      check_cancelled(result, folder, {"r.json", "sleeper"});
      CHECK_THAT(result.err, Catch::Contains("cancelled"));
      const auto seconds = read_json(folder / "r.json")["seconds"];
      // The stage that the signal was meant for, and those before; on a busy machine it may come in a later one.
      CHECK(seconds["read"] > 0);
      if (std::string(stage) != "read") {
        CHECK(seconds["size_field"] > 0);
        CHECK(seconds["surface"] > 0);
      }
      if (volume) CHECK(seconds["volume"] > 0);
      return result.seconds_after_signal < kMostSecondsToCancel;
    }));
  }
}

TEST_CASE("help goes to standard output and is no error") {
  const ProcessResult help = run_tetloom({"--help"});
  CHECK(help.status == 0);
  CHECK_THAT(help.out, Catch::Contains("tetloom mesh part.step -o part.vtu"));
  const ProcessResult version = run_tetloom({"--version"});
  CHECK(version.status == 0);
  CHECK(std::regex_match(version.out, std::regex("tetloom [0-9]+\\.[0-9]+\\.[0-9]+\\n")));
  CHECK(run_tetloom({}).status == 2);
}

TEST_CASE("check and info describe a mesh of all kinds of cells and its fields") {
  const TestFolder folder;
  tetloom::Mesh mesh = make_mixed_box(3, 3, 4);
  mesh.point_fields = {{"heat", 1, std::vector<double>(mesh.points.size())}};
  mesh.cell_fields = {{"flow", 3, std::vector<double>(3 * tetloom::cell_count(mesh))}};
  tetloom::write_mesh(mesh, folder / "mixed.vtu");
  for (const char* command : {"check", "info"}) {
    CAPTURE(command);
    const ProcessResult result = run_tetloom({command, folder / "mixed.vtu", "--report", folder / "report.json"});
    CAPTURE(result.err);
    REQUIRE(result.status == 0);
    CHECK_THAT(result.out, Catch::Contains(std::to_string(mesh.prism_to_vert.size()) + " prisms"));
    CHECK_THAT(result.out, Catch::Contains("heat on points") && Catch::Contains("flow on cells, 3 components"));
    const nlohmann::json report = read_json(folder / "report.json");
    CHECK(report["volume"]["mesh"].get<double>() == Approx(36));
    CHECK(report["mesh"]["hexahedra"] == mesh.hex_to_vert.size());
    CHECK(report["mesh"]["cell_fields"][0]["name"] == "flow");
    CHECK(report["mesh"]["regions"][0]["cells"] == tetloom::cell_count(mesh));
  }
}
