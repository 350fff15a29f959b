// The command `adapt` with models.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>

#include "core/geometry/model_projector.hpp"
#include "tests/apps/command_process.hpp"
#include "tetloom/io.hpp"
#include "tetloom/model.hpp"

using namespace tetloom::test;

namespace {

std::string mesh_of(const TestFolder& folder, const std::string& model, const std::string& name, double size) {
  const ProcessResult result =
      run_tetloom({"mesh", model, "-o", folder / name, "--size", std::to_string(size), "--quiet"});
  CAPTURE(result.err);
  REQUIRE(result.status == 0);
  return folder / name;
}

/// A metric of that size for the mesh in `file`.
std::string sizes_for(const TestFolder& folder, const std::string& file, double size) {
  const tetloom::Mesh mesh = tetloom::read_mesh(file);
  tetloom::write_solution({{{"h", 1, std::vector<double>(mesh.points.size(), size)}}, {}}, tetloom::solution_size(mesh),
                          folder / "h.solb");
  return folder / "h.solb";
}

/// How many points do not lie on the face or edge that they are classified on, by more than a millionth of the model.
std::size_t count_off(const std::string& file, const std::string& model_file) {
  const tetloom::Mesh mesh = tetloom::read_mesh(file);
  const tetloom::ModelDocument document = tetloom::read_model(model_file);
  const auto project = tetloom::make_projector(*document.model);
  const double tolerance = 1e-6 * document.model->bounding_box().diagonal();
  std::size_t off = 0;
  for (std::size_t v = 0; v < mesh.points.size(); ++v) {
    const tetloom::ModelEntity entity = mesh.point_to_entity[v];
    if (entity.dim != 1 && entity.dim != 2) continue;
    const auto spot = project(entity, mesh.points[v]);
    off += !spot || distance(spot->point, mesh.points[v]) > tolerance;
  }
  return off;
}

}  // namespace

TEST_CASE("all points made on fillets and in holes lie on them") {
  const TestFolder folder;
  const double coarse = 10, fine = 5;
  const std::string model = demo_model("machined-part"), mesh = mesh_of(folder, model, "coarse.vtu", coarse);
  REQUIRE(count_off(mesh, model) == 0);
  const ProcessResult result = run_tetloom({"adapt", mesh, "-o", folder / "fine.vtu", "--metric",
                                            sizes_for(folder, mesh, fine), "--model", model, "--quiet"});
  CAPTURE(result.err);
  REQUIRE(result.status == 0);
  CHECK(count_off(folder / "fine.vtu", model) == 0);
  const ProcessResult again =
      run_tetloom({"adapt", folder / "fine.vtu", "-o", folder / "again.vtu", "--metric",
                   sizes_for(folder, folder / "fine.vtu", coarse), "--model", model, "--quiet"});
  CAPTURE(again.err);
  CHECK(again.status == 0);
  CHECK(count_off(folder / "again.vtu", model) == 0);
}

TEST_CASE("fields on cells keep their integrals while a CAD part is adapted to and fro") {
  const TestFolder folder;
  const std::string model = demo_model("machined-part");
  std::string last = mesh_of(folder, model, "0.vtu", 12);
  tetloom::Mesh mesh = tetloom::read_mesh(last);
  tetloom::MeshField mass{"mass", 1, {}};
  for (const auto& tet : mesh.tet_to_vert) mass.values.push_back(std::max(0.0, mesh.points[tet[0]].x));
  mesh.cell_fields = {mass};
  tetloom::write_mesh(mesh, last);
  double before = 0;
  for (int i = 1; i <= 4; ++i) {
    const std::string next = folder / (std::to_string(i) + ".vtu");
    const ProcessResult result =
        run_tetloom({"adapt", last, "-o", next, "--metric", sizes_for(folder, last, i % 2 != 0 ? 7 : 12), "--model",
                     model, "--transfer", "mass", "--report", folder / "r.json"});
    CAPTURE(i, result.err);
    REQUIRE(result.status == 0);
    const auto figures = read_json(folder / "r.json")["adaptation"]["transfer"][0]["components"][0];
    if (i == 1) before = figures["integral"][0];
    CHECK(figures["integral"][1].get<double>() == Approx(before).epsilon(1e-12));
    CHECK(figures["least"][1] >= 0);
    last = next;
  }
}

TEST_CASE("adapt follows the CAD model that the mesh was made from") {
  const TestFolder folder;
  const std::string model = demo_model("sphere");
  double h = 30;
  std::string last = mesh_of(folder, model, "0.vtu", h);
  const std::string extension = GENERATE(".vtu", ".msh", ".meshb");
  double volume_error = 1e300;
  const double wanted = 4 * std::acos(-1.0) / 3 * 50 * 50 * 50;
  for (int i = 1; i <= 2; ++i) {
    h /= 2;
    CAPTURE(i, extension);
    const std::string next = folder / (std::to_string(i) + extension);
    const ProcessResult result = run_tetloom({"adapt", last, "-o", next, "--metric", sizes_for(folder, last, h),
                                              "--model", model, "--report", folder / "r.json"});
    CAPTURE(result.err);
    REQUIRE(result.status == 0);
    const auto report = read_json(folder / "r.json");
    CHECK(report["adaptation"]["after"]["unit_edges"] > 0.9);
    const double off = std::abs(report["volume"]["mesh"].get<double>() - wanted);
    if (i > 1) CHECK(off < volume_error / 3);
    volume_error = off;
    last = next;
  }
}

TEST_CASE("adapt refuses a model of another part") {
  const TestFolder folder;
  const std::string mesh = mesh_of(folder, demo_model("sphere"), "sphere.vtu", 30);
  const ProcessResult result = run_tetloom({"adapt", mesh, "-o", folder / "out.vtu", "--metric",
                                            sizes_for(folder, mesh, 15), "--model", demo_model("plate")});
  CHECK(result.status == 3);
  CHECK_THAT(result.err, Catch::Contains("model"));
}

TEST_CASE("adapt limits sizes by the curvature of the model") {
  const TestFolder folder;
  const std::string model = demo_model("sphere");
  const std::string mesh = mesh_of(folder, model, "sphere.vtu", 25);
  const ProcessResult result =
      run_tetloom({"adapt", mesh, "-o", folder / "out.vtu", "--metric", sizes_for(folder, mesh, 50), "--model", model,
                   "--curvature", "24", "--gradation", "1.5", "--report", folder / "r.json"});
  CAPTURE(result.err);
  REQUIRE(result.status == 0);
  const auto report = read_json(folder / "r.json");
  CHECK(report["counts"]["triangles"] > 300);
}
