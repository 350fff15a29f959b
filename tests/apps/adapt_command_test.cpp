// The command that leads meshes to metrics.
#include <signal.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <filesystem>
#include <fstream>

#include "tests/apps/command_process.hpp"
#include "tests/support/mixed_mesh.hpp"
#include "tetloom/check.hpp"
#include "tetloom/io.hpp"

using namespace tetloom::test;
using tetloom::Mesh;
using tetloom::MeshField;
using tetloom::Vec3;

namespace {

/// The unit cube with a solution that has a layer, its size field, and the same as a tensor in VTK's order.
Mesh cube_with_fields(int n = 4) {
  BoxSpec spec{n, n, n, false, 1};
  spec.h = 1.0 / n;
  Mesh mesh = make_tet_box(spec);
  MeshField heat{"heat", 1, {}}, size{"size", 1, {}}, tensor{"tensor", 6, {}}, linear{"linear", 1, {}};
  for (const Vec3& x : mesh.points) {
    const double hz = 0.05 + 0.1 * x.z;
    heat.values.push_back(std::tanh(10 * (x.x - 0.4)));
    size.values.push_back(hz);
    linear.values.push_back(x.x + 2 * x.y - x.z);
    tensor.values.insert(tensor.values.end(), {25, 25, 1 / (hz * hz), 0, 0, 0});
  }
  mesh.point_fields = {heat, size, tensor, linear};
  MeshField mass{"mass", 1, {}}, both{"heat", 2, {}};  // one with a name that is on points too
  for (const auto& tet : mesh.tet_to_vert) {
    const double x = mesh.points[tet[0]].x;
    mass.values.push_back(x > 0.4 ? 3 : 1);
    both.values.insert(both.values.end(), {x, -x});
  }
  mesh.cell_fields = {mass, both};
  return mesh;
}

std::string write_cube(const TestFolder& folder, const std::string& name, int n = 4) {
  Mesh mesh = cube_with_fields(n);
  const std::string path = folder / name;
  tetloom::write_mesh(mesh, path);
  return path;
}

/// Runs `adapt`, which must succeed, and returns its report.
nlohmann::json adapt(const TestFolder& folder, const std::string& from, const std::string& to,
                     const std::vector<std::string>& more) {
  std::vector<std::string> arguments{"adapt", from, "-o", folder / to, "--report", folder / "report.json"};
  arguments.insert(arguments.end(), more.begin(), more.end());
  const ProcessResult result = run_tetloom(arguments);
  CAPTURE(result.err);
  REQUIRE(result.status == 0);
  return read_json(folder / "report.json");
}

ProcessResult adapt_wrongly(const std::string& from, const std::string& to, const std::vector<std::string>& more) {
  std::vector<std::string> arguments{"adapt", from, "-o", to};
  arguments.insert(arguments.end(), more.begin(), more.end());
  return run_tetloom(arguments);
}

}  // namespace

TEST_CASE("adapt writes parts and reads them") {
  const TestFolder folder;
  const std::string cube = write_cube(folder, "cube.vtu");
  const std::vector<std::string> options{"--metric-field", "size", "--transfer", "size,linear"};
  const auto whole = adapt(folder, cube, "out.vtu", options);
  auto with_parts = options;
  with_parts.insert(with_parts.end(), {"--parts", "4"});
  const auto parts = adapt(folder, cube, "out.pvtu", with_parts);
  CHECK(parts["parts"] == 4);
  CHECK(parts["digest"] == whole["digest"]);
  CHECK(parts["counts"] == whole["counts"]);
  CHECK(parts["validation"]["valid"] == true);
  CHECK(parts["partition"]["table"].size() == 4);
  CHECK(parts["partition"]["imbalance"]["elements"] < 0.1);
  REQUIRE(run_tetloom({"check", folder / "out.pvtu", "--quiet", "--report", folder / "check.json"}).status == 0);
  CHECK(read_json(folder / "check.json")["digest"] == whole["digest"]);
  // The fields are in the pieces, and lead the next step.
  const auto next = adapt(folder, folder / "out.pvtu", "next.vtu", options);
  CHECK(next["adaptation"]["before"]["edges"] == whole["adaptation"]["after"]["edges"]);
  CHECK(next["status"] == "ok");
}

TEST_CASE("adapt leads a mesh to a metric from a field, and reports") {
  const TestFolder folder;
  const std::string cube = write_cube(folder, "cube.vtu");
  const std::string field = GENERATE("size", "tensor");
  CAPTURE(field);
  const auto report = adapt(folder, cube, "out.vtu", {"--metric-field", field, "--transfer", "linear,heat"});
  CHECK(report["status"] == "ok");
  CHECK(report["validation"]["valid"] == true);
  const auto& adaptation = report["adaptation"];
  for (const char* when : {"before", "after"}) {
    const auto& conformity = adaptation[when];
    CHECK(conformity["shortest"] > 0);
    CHECK(conformity["longest"] > conformity["shortest"]);
    CHECK(conformity["quality_histogram"].size() == 10);
    CHECK(conformity["quality_min"] <= conformity["quality_mean"]);
    CHECK(conformity["complexity"] > 0);
  }
  CHECK(adaptation["after"]["unit_edges"] > 0.95);
  CHECK(adaptation["after"]["unit_edges"] > adaptation["before"]["unit_edges"]);
  CHECK(adaptation["after"]["half_to_two"] > 0.99);
  for (const char* operation : {"splits", "collapses", "swaps", "moves"}) {
    const auto& counts = adaptation["operations"][operation];
    std::size_t refused = 0;
    for (const auto& [reason, count] : counts["refused_by"].items()) refused += count.get<std::size_t>();
    CHECK(counts["refused"] == refused);
    CHECK(counts["refused_by"].contains("quality"));
  }
  CHECK(adaptation["operations"]["splits"]["done"] > 0);
  CHECK(adaptation["rounds"] > 0);
  CHECK(adaptation["most_parts"] == (field == "size" ? 2 : 1));
  CHECK(adaptation["points_beside_model"] == 0);
  CHECK(adaptation["seconds"]["adapt"] > 0);
  CHECK(report["volume"]["mesh"] == Approx(1).epsilon(1e-12));

  const Mesh result = tetloom::read_mesh(folder / "out.vtu");
  CHECK(report["digest"] == tetloom::mesh_digest(result));
  CHECK(report["counts"]["tets"] == result.tet_to_vert.size());
  REQUIRE(result.point_fields.size() == 2);
  REQUIRE(result.point_fields[0].name == "linear");
  for (std::size_t v = 0; v < result.points.size(); ++v) {
    const Vec3& x = result.points[v];
    CHECK(result.point_fields[0].values[v] == Approx(x.x + 2 * x.y - x.z).margin(1e-12));
  }
  CHECK(run_tetloom({"check", folder / "out.vtu"}).status == 0);
}

TEST_CASE("adapt carries fields on cells over, and reports what becomes of them") {
  const TestFolder folder;
  const std::string extension = GENERATE(".vtu", ".msh");
  const std::string cube = write_cube(folder, "cube" + extension), order = GENERATE("1", "2");
  const auto report = adapt(folder, cube, "out" + extension,
                            {"--metric-field", "size", "--transfer", "mass,heat", "--transfer-order", order});
  const auto& transfer = report["adaptation"]["transfer"];
  REQUIRE(transfer.size() == 3);
  CHECK((transfer[0]["name"] == "heat" && transfer[0]["on"] == "points"));
  CHECK((transfer[1]["name"] == "mass" && transfer[1]["on"] == "cells"));
  CHECK((transfer[2]["name"] == "heat" && transfer[2]["components"].size() == 2));
  const auto& mass = transfer[1]["components"][0];
  CHECK(mass["integral"][1].get<double>() == Approx(mass["integral"][0].get<double>()).epsilon(1e-13));
  CHECK(std::abs(mass["change"].get<double>()) < 1e-13);
  CHECK((mass["least"][0] == 1 && mass["greatest"][0] == 3));
  CHECK(mass["least"][1].get<double>() == Approx(1).epsilon(1e-12));
  CHECK(mass["greatest"][1].get<double>() == Approx(3).epsilon(1e-12));

  const Mesh result = tetloom::read_mesh(folder / ("out" + extension));
  REQUIRE(result.point_fields.size() == 1);
  REQUIRE(result.cell_fields.size() == 2);
  REQUIRE(result.cell_fields[0].name == "mass");
  CHECK(result.cell_fields[1].components == 2);
  for (const double value : result.cell_fields[0].values) CHECK((value > 1 - 1e-12 && value < 3 + 1e-12));
}

TEST_CASE("adapt tells of a metric that turns faster than elements can") {
  const TestFolder folder;
  Mesh mesh = cube_with_fields();
  MeshField turning{"turning", 6, {}};
  for (const Vec3& x : mesh.points) {
    // Sizes of 0.5, 0.005 and 0.2, the first two turned about z.
    const double c = std::cos(3 * x.x), s = std::sin(3 * x.x), along = 4, across = 40000;
    turning.values.insert(turning.values.end(), {along * c * c + across * s * s, along * s * s + across * c * c, 25,
                                                 (along - across) * c * s, 0, 0});
  }
  mesh.point_fields.push_back(turning);
  tetloom::write_mesh(mesh, folder / "cube.vtu");
  const auto size = adapt(folder, folder / "cube.vtu", "out.vtu", {"--metric-field", "size"});
  CHECK(size["adaptation"]["turning_limited"].is_null());
  const ProcessResult result = run_tetloom({"adapt", folder / "cube.vtu", "-o", folder / "turned.vtu", "--metric-field",
                                            "turning", "--report", folder / "report.json"});
  REQUIRE(result.status == 0);
  CHECK(result.out.find("turns faster than elements can") != std::string::npos);
  const auto adaptation = read_json(folder / "report.json")["adaptation"];
  const auto& limited = adaptation["turning_limited"];
  CHECK(limited["complexity_followed"] > limited["complexity_asked"]);
  CHECK(adaptation["after"]["unit_edges"] > 0.9);
}

TEST_CASE("adapt makes a metric from a solution") {
  const TestFolder folder;
  const std::string cube = write_cube(folder, "cube.vtu", 8);
  const std::string extension = GENERATE(".vtu", ".msh");
  const auto report = adapt(folder, cube, "out" + extension,
                            {"--hessian", "heat", "--complexity", "400", "--norm", "1", "--h-max", "0.5"});
  CHECK(report["adaptation"]["before"]["complexity"] == Approx(400).epsilon(0.02));
  CHECK(report["adaptation"]["after"]["unit_edges"] > 0.9);
  const double tets = report["counts"]["tets"];
  CHECK(tets > 1500);
  CHECK(tets < 8000);
}

TEST_CASE("adapt reads and writes MEDIT's files, with fields beside the mesh") {
  const TestFolder folder;
  const bool binary = GENERATE(false, true);
  const std::string mesh_end = binary ? ".meshb" : ".mesh", sol_end = binary ? ".solb" : ".sol";
  const Mesh mesh = cube_with_fields();
  tetloom::write_mesh(mesh, folder / ("cube" + mesh_end));
  tetloom::write_solution({{mesh.point_fields[1]}, {}}, tetloom::solution_size(mesh), folder / ("metric" + sol_end));
  tetloom::write_solution({{mesh.point_fields[3], mesh.point_fields[0]}, {mesh.cell_fields[0]}},
                          tetloom::solution_size(mesh), folder / ("cube" + sol_end));
  adapt(folder, folder / ("cube" + mesh_end), "out" + mesh_end,
        {"--metric", folder / ("metric" + sol_end), "--transfer", "solution_1"});
  const Mesh out = tetloom::read_mesh(folder / ("out" + mesh_end));
  const auto solution = tetloom::read_solution(folder / ("out" + sol_end), tetloom::solution_size(out));
  const auto& fields = solution.point_fields;
  REQUIRE(fields.size() == 1);
  REQUIRE(solution.tet_fields.size() == 1);
  CHECK(*std::max_element(solution.tet_fields[0].values.begin(), solution.tet_fields[0].values.end()) ==
        Approx(3).epsilon(1e-12));
  for (std::size_t v = 0; v < out.points.size(); ++v) {
    const Vec3& x = out.points[v];
    CHECK(fields[0].values[v] == Approx(x.x + 2 * x.y - x.z).margin(1e-12));
  }
  // Once more, from what was written: the classification has survived.
  const auto again = adapt(folder, folder / ("cube" + mesh_end), "again" + mesh_end,
                           {"--hessian", "solution_2", "--complexity", "300"});
  CHECK(again["volume"]["mesh"] == Approx(1).epsilon(1e-12));
  CHECK_FALSE(std::filesystem::exists(folder / ("again" + sol_end)));
}

TEST_CASE("the adapted mesh does not depend on threads") {
  const TestFolder folder;
  const std::string cube = write_cube(folder, "cube.vtu", 6);
  const std::vector<std::string> common{"--metric-field", "size", "--tets-per-part", "2000", "--threads"};
  const auto run = [&](const std::string& threads) {
    std::vector<std::string> arguments = common;
    arguments.push_back(threads);
    return adapt(folder, cube, "out" + threads + ".vtu", arguments);
  };
  const auto one = run("1"), three = run("3");
  CHECK(one["digest"] == three["digest"]);
  CHECK(one["parts"] > 1);
  CHECK(read_text(folder / "out1.vtu") == read_text(folder / "out3.vtu"));
}

TEST_CASE("adapt tells a person what became of the mesh") {
  const TestFolder folder;
  const std::string cube = write_cube(folder, "cube.vtu", 2);
  const ProcessResult result =
      run_tetloom({"adapt", cube, "-o", folder / "out.vtu", "--metric-field", "size", "--transfer", "mass,linear"});
  CHECK(result.status == 0);
  CHECK_THAT(result.out, Catch::Contains("in [0.707, 1.414]") && Catch::Contains("collapses") &&
                             Catch::Contains("digest") && Catch::Contains("rounds") &&
                             Catch::Contains("integral before") && Catch::Contains("mass"));
  CHECK_THAT(result.err, Catch::Contains("adapt"));
  const ProcessResult quiet =
      run_tetloom({"adapt", cube, "-o", folder / "quiet.vtu", "--metric-field", "size", "--quiet"});
  CHECK(quiet.out.empty());
  CHECK(quiet.err.empty());
}

TEST_CASE("bad input of adapt ends with what is wrong with it") {
  const TestFolder folder;
  Mesh mesh = cube_with_fields(2);
  const std::string out = folder / "out.vtu", report_file = folder / "report.json";
  const auto refused = [&](const std::string& input, const std::vector<std::string>& more, const std::string& why) {
    std::vector<std::string> arguments = more;
    arguments.insert(arguments.end(), {"--report", report_file});
    const ProcessResult result = adapt_wrongly(input, out, arguments);
    CAPTURE(result.err, more);
    CHECK(result.status == 3);
    CHECK_THAT(result.err, Catch::Contains(why));
    CHECK_FALSE(std::filesystem::exists(out));
    CHECK(read_json(report_file)["status"] == "failed");
  };
  const std::string cube = folder / "cube.vtu";
  SECTION("files and fields") {
    tetloom::write_mesh(mesh, cube);
    refused(folder / "nothing.vtu", {"--metric-field", "size"}, "nothing.vtu");
    refused(folder.write("broken.vtu", "<VTKFile"), {"--metric-field", "size"}, "broken.vtu");
    refused(cube, {"--metric-field", "pressure"}, "\"heat\", \"size\"");
    refused(cube, {"--hessian", "pressure", "--complexity", "100"}, "pressure");
    refused(cube, {"--hessian", "tensor", "--complexity", "100"}, "one component");
    refused(cube, {"--metric-field", "size", "--transfer", "mass,pressure"},
            "\"pressure\" to transfer; on its points there are \"heat\"");
    refused(cube, {"--metric-field", "size", "--transfer", "pressure"}, "on its cells there are \"mass\"");
    refused(cube, {"--metric", folder / "nothing.sol"}, "nothing.sol");
    refused(cube, {"--metric-field", "size", "--model", folder / "nothing.step"}, "nothing.step");
    const std::string few =
        folder.write("few.sol", "MeshVersionFormatted 2\nDimension 3\nSolAtVertices\n3\n1 1\n1 1 1\nEnd\n");
    refused(cube, {"--metric", few}, "the mesh has 27");
    tetloom::write_mesh(mesh, folder / "bare.mesh");
    refused(folder / "bare.mesh", {"--metric-field", "solution_1"}, "bare.sol");
  }
  SECTION("a field on cells that is not finite") {
    mesh.cell_fields[0].values[7] = GENERATE(std::nan(""), -HUGE_VAL);
    tetloom::write_mesh(mesh, cube);
    refused(cube, {"--metric-field", "size", "--transfer", "mass"}, "not finite");
  }
  SECTION("a metric that is none") {
    const double bad = GENERATE(-1.0, 0.0, std::nan(""), HUGE_VAL);
    mesh.point_fields[1].values[5] = bad;
    tetloom::write_mesh(mesh, cube);
    refused(cube, {"--metric-field", "size"}, "near (");
  }
  SECTION("a tensor that is not positive definite") {
    mesh.point_fields[2].values[6 * 5 + 2] = -1;
    tetloom::write_mesh(mesh, cube);
    refused(cube, {"--metric-field", "tensor"}, "near (");
  }
  SECTION("a field with two components as a metric") {
    mesh.point_fields = {{"pair", 2, std::vector<double>(2 * mesh.points.size(), 1)}};
    tetloom::write_mesh(mesh, cube);
    refused(cube, {"--metric-field", "pair"}, "components");
  }
  SECTION("a mesh without classification") {
    mesh.tri_to_vert.clear(), mesh.tri_to_entity.clear(), mesh.edge_to_vert.clear(), mesh.edge_to_entity.clear();
    tetloom::write_mesh(mesh, cube);
    refused(cube, {"--metric-field", "size"}, "model face");
  }
  SECTION("a surface") {
    refused(folder.write("cube.stl", cube_stl()), {"--hessian", "heat", "--complexity", "100"}, "");
  }
  SECTION("other cells") {
    Mesh mixed = make_mixed_box(4, 4, 4);
    mixed.point_fields = {{"size", 1, std::vector<double>(mixed.points.size(), 1)}};
    tetloom::write_mesh(mixed, cube);
    refused(cube, {"--metric-field", "size"}, "tetrahedra");
  }
}

TEST_CASE("a metric beyond all memory is refused") {
  const TestFolder folder;
  const std::string cube = write_cube(folder, "cube.vtu", 2);
  const ProcessResult result =
      adapt_wrongly(cube, folder / "out.vtu", {"--metric-field", "size", "--h-max", "0.00001"});
  CHECK(result.status == 6);
  CHECK_FALSE(std::filesystem::exists(folder / "out.vtu"));
}

TEST_CASE("adapt ends soon after Ctrl-C and leaves nothing behind") {
  ProcessOptions options;
  options.signal_when = "adapt";
  options.signals = {SIGINT};
  CHECK(in_time([&]() -> std::optional<bool> {
    const TestFolder folder;
    const std::string cube = write_cube(folder, "cube.vtu");
    const ProcessResult result = run_tetloom({"adapt", cube, "-o", folder / "out.vtu", "--metric-field", "size",
                                              "--h-max", "0.02", "--report", folder / "r.json"},
                                             options);
    if (result.status == 0) return std::nullopt;
    check_cancelled(result, folder, {"cube.vtu", "r.json"});
    return result.seconds_after_signal < kMostSecondsToCancel;
  }));
}
