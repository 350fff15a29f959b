// Solids that cross themselves: the command makes them anew and meshes again.
#include <algorithm>
#include <catch2/catch.hpp>
#include <string>
#include <vector>

#include "apps/tetloom/solid_copies.hpp"
#include "bench/support/surface_distance.hpp"
#include "tests/apps/command_process.hpp"
#include "tests/cad/faulty_samples.hpp"
#include "tetloom/io.hpp"
#include "tetloom/model.hpp"

using namespace tetloom;
using namespace tetloom::test;

namespace {

struct Repaired {
  TestFolder folder;
  nlohmann::json report;

  explicit Repaired(Fault fault, const std::string& size, const std::string& threads = "1") {
    write_faulty(fault, folder / "model.brep");
    const ProcessResult result =
        run_tetloom({"mesh", folder / "model.brep", "-o", folder / "mesh.vtu", "--report", folder / "report.json",
                     "--size", size, "--curvature", "24", "--threads", threads});
    INFO(result.err);
    REQUIRE(result.status == 0);
    report = read_json(folder / "report.json");
  }
};

std::string digest_of(const Repaired& run) { return run.report["digest"].get<std::string>(); }

}  // namespace

TEST_CASE("a solid that crosses itself is made anew, and the report says which it was") {
  const Repaired run(Fault::FloorBeyondOuterFace, "2");
  CHECK(run.report["rebuilt"] == nlohmann::json::parse("[[1]]"));
  CHECK(run.report["counts"]["regions"] == 2);
  CHECK(run.report["errors"].empty());
  CHECK(digest_of(run) == digest_of(Repaired(Fault::FloorBeyondOuterFace, "2", "3")));

  // The mesh is classified on the model with these solids, not on the one in the file.
  const Mesh mesh = read_mesh(run.folder / "mesh.vtu");
  const ModelDocument document = read_model(run.folder / "model.brep");
  CHECK(bench::surface_distance(mesh, *document.model) > 1);
  const auto rebuilt = rebuild_solids(document, {ModelRegionId(0)});
  REQUIRE(rebuilt.has_value());
  CHECK(bench::surface_distance(mesh, *rebuilt->model) < 0.2);
}

TEST_CASE("the seconds of a run that repaired its model are those of all attempts") {
  // The first attempt ends after many rounds, because faces that touch may be triangles that are too coarse; the next
  // one takes a small part of that.
  const nlohmann::json seconds = Repaired(Fault::FloorInOuterFace, "1").report["seconds"];
  const double total = seconds["total"].get<double>();
  double sum = 0;
  for (const char* stage : {"read", "size_field", "surface", "volume", "check", "write"})
    sum += seconds[stage].get<double>();
  CHECK(sum > 0.5 * total);
}

TEST_CASE("a mesh of solids that were made anew is adapted to the same model") {
  const Repaired run(Fault::FloorBeyondOuterFace, "2");
  const nlohmann::json& warnings = run.report["warnings"];
  const bool is_told = std::ranges::any_of(warnings, [](const nlohmann::json& warning) {
    return warning["message"].get<std::string>().find("--rebuild 1") != std::string::npos;
  });
  CHECK(is_told);
  Mesh mesh = read_mesh(run.folder / "mesh.vtu");
  mesh.point_fields = {{"size", 1, std::vector<double>(mesh.points.size(), 3.0)}};
  write_mesh(mesh, run.folder / "sized.vtu");

  const std::vector<std::string> adapt{
      "adapt",   run.folder / "sized.vtu", "-o", run.folder / "adapted.vtu", "--metric-field", "size",
      "--model", run.folder / "model.brep"};
  const auto with = [](std::vector<std::string> arguments, const std::vector<std::string>& more) {
    arguments.insert(arguments.end(), more.begin(), more.end());
    return run_tetloom(arguments).status;
  };
  CHECK(with(adapt, {}) == 3);
  CHECK(with(adapt, {"--rebuild", "1"}) == 0);
  CHECK(with(adapt, {"--rebuild", "7"}) == 3);
  for (const char* bad : {"", "0", "-1", "1,", "1;2", "x", "99999999999"}) {
    CAPTURE(bad);
    CHECK(with(adapt, {std::string("--rebuild=") + bad}) == 2);
  }

  // What is asked for is not found out again.
  CHECK(with({"mesh", run.folder / "model.brep", "-o", run.folder / "again.vtu", "--report", run.folder / "again.json",
              "--size", "2", "--curvature", "24", "--threads", "1"},
             {"--rebuild", "1"}) == 0);
  const nlohmann::json again = read_json(run.folder / "again.json");
  CHECK(again["digest"] == run.report["digest"]);
  CHECK(again["rebuilt"] == run.report["rebuilt"]);
}

TEST_CASE("solids of the shape of one that crosses itself are made anew with it") {
  TestFolder folder;
  write_faulty(Fault::FloorsBeyondOuterFaces, folder / "model.brep");
  const ModelDocument document = read_model(folder / "model.brep");
  const auto solid = [](std::uint32_t tag) { return ModelRegionId(tag - 1); };
  const std::vector<ModelRegionId> boxes_with_holes{solid(2), solid(3), solid(4), solid(5), solid(6), solid(7)};
  CHECK(app::with_copies({solid(3)}, *document.model) == boxes_with_holes);
  CHECK(app::with_copies({solid(1)}, *document.model) == std::vector{solid(1)});
  CHECK(app::with_copies({}, *document.model).empty());

  const Repaired run(Fault::FloorsBeyondOuterFaces, "4");
  CHECK(run.report["rebuilt"] == nlohmann::json::parse("[[2, 3, 4, 5, 6, 7]]"));
  CHECK(run.report["counts"]["regions"] == 7);
}
