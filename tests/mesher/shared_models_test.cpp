// Real CAD models from STEP, IGES or BREP file to a validated tetrahedral mesh, at two sizes, judged by tetloom's own
// checks and by an independent script, and filled without TetGen. Prints a table. Skipped with a message where the
// models are not there.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <set>

#include "tests/mesher/real_models.hpp"
#include "tests/support/temporary_folder.hpp"
#include "tetloom/check.hpp"
#include "tetloom/io.hpp"
#include "tetloom/mesh.hpp"
#include "tetloom/model.hpp"

using namespace tetloom;
namespace fs = std::filesystem;

namespace {

const fs::path kJudge = fs::path(TETLOOM_SHARED_DIR) / "tools/quality.py";

// What shared/tools/quality.py says of the mesh, or an empty object where it cannot run.
nlohmann::json ask_judge(const Mesh& mesh, double size) {
  if (!fs::exists(kJudge) || std::system("/usr/bin/python3 -c 'import numpy' 2>/dev/null") != 0) return {};
  const test::TemporaryFolder folder;
  const fs::path file = folder / "mesh.msh", answer = folder / "answer.json";
  write_mesh(mesh, file);
  const std::string command = "/usr/bin/python3 '" + kJudge.string() + "' '" + file.string() + "' " +
                              std::to_string(size) + " > '" + answer.string() + "'";
  REQUIRE(std::system(command.c_str()) == 0);
  return nlohmann::json::parse(test::file_content(answer));
}

struct Figures {
  double volume = 0, model_volume = 0;
  bool valid = false;
  std::size_t regions_filled = 0, regions = 0;
  long long inverted_by_judge = -1;
};

Figures judge(const MeshResult& result, const GeometricModel& model) {
  Figures figures;
  figures.regions = model.topology().region_count();
  const QualityReport quality = compute_quality(result.mesh, &result.sizes);
  figures.volume = quality.tets.volume;
  figures.model_volume = result.model_volume;
  figures.valid = validate_mesh(result.mesh).problems.empty() && quality.cells.inverted == 0;
  figures.regions_filled =
      std::set<std::uint32_t>(result.mesh.tet_to_entity.begin(), result.mesh.tet_to_entity.end()).size();
  return figures;
}

void print_heading() {
  std::printf("%-52s %9s %9s %9s %8s %5s %5s %6s %7s %6s %6s %6s\n", "model", "triangles", "tets", "regions", "volume",
              "valid", "inv.", "tetgen", "missing", "points", "< 15", "forced");
}

// Beside what there is: complexes that TetGen filled, missing triangles, points put inside to recover them, tets with
// an angle below 15 degrees, and those of them to which the surface leaves no choice.
void print_row(const std::string& name, const MeshResult& result, const Figures& figures) {
  const FillingFigures& filling = result.filling;
  std::printf("%-52.52s %9zu %9zu %4zu/%-4zu %+7.2f%% %5s %5lld %6zu %7zu %6zu %6zu %6zu\n", name.c_str(),
              result.mesh.tri_to_vert.size(), result.mesh.tet_to_vert.size(), figures.regions_filled, figures.regions,
              100 * (figures.volume / figures.model_volume - 1), figures.valid ? "yes" : "NO",
              figures.inverted_by_judge, filling.worker_complexes, filling.missing_triangles, filling.recovery_points,
              filling.optimizer.below_dihedral, filling.optimizer.forced);
  std::fflush(stdout);
}

/// `judged`: by an independent judge as well, which reads text and so takes long.
void mesh_all(double relative_size, bool judged) {
  const std::vector<fs::path> models = test::list_real_models();
  if (models.empty()) {
    WARN("skipped: no models in " << test::kRealModels);
    return;
  }
  print_heading();
  for (const fs::path& file : models) {
    INFO(file);
    const ModelDocument document = read_model(file);
    MeshOptions options;
    options.sizes.relative_size = relative_size;
    options.sizes.curvature = 24;
    options.volume_worker = TETLOOM_WORKER;
    const MeshResult result = make_mesh(*document.model, options);
    CHECK(result.status == MeshStatus::Ok);
    for (const Diagnostic& error : result.errors) UNSCOPED_INFO(error.message);
    Figures figures = judge(result, *document.model);
    if (judged) {
      const nlohmann::json answer = ask_judge(result.mesh, relative_size * document.model->bounding_box().diagonal());
      if (!answer.empty()) figures.inverted_by_judge = answer.at("inverted").get<long long>();
    }
    print_row(file.filename().string(), result, figures);
    CHECK(figures.valid);
    CHECK(figures.regions_filled == figures.regions);
    CHECK(figures.volume == Approx(figures.model_volume).epsilon(0.01));
    CHECK(figures.inverted_by_judge <= 0);
    CHECK(result.filling.worker_complexes == 0);
  }
}

}  // namespace

TEST_CASE("real CAD models are filled at a size of a fortieth of the diagonal", "[fortieth]") {
  mesh_all(1.0 / 40, true);
}

TEST_CASE("real CAD models are filled at a size of a hundredth of the diagonal", "[hundredth]") {
  mesh_all(1.0 / 100, false);
}
